// Changes of punctual lights: from a request for one frame, from a sidecar file for the loaded
// scene.
#pragma once

#include "scene/fields.h"
#include "scene/scene.h"

#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// Selects the lights of the name `light`; without a name, all.
struct LightOverride {
    std::optional<std::string> light;
    std::optional<double> radius;
};

template <class O, class V>
requires std::same_as<std::remove_const_t<O>, LightOverride>
void fields(O& o, V&& visit) {
    visit("light", o.light, Text{256}, "name of the light that it changes; absent: all lights");
    visit("radius", o.radius, Range{0, 1e9},
          "of the sphere that shines, metres; of a directional light: at a distance of one metre "
          "(the sun: 0.0047); 0: shadows have sharp edges");
}

// Checks that the names exist in the scene. `pointer` is the JSON Pointer of the list.
std::vector<FieldError> problems(const Scene& scene, const std::vector<LightOverride>& overrides,
                                 const std::string& pointer = "/lights");

// The lights with the overrides applied in order. A name that no light has is no error.
std::vector<Light> lightsWith(std::vector<Light> lights,
                              const std::vector<LightOverride>& overrides);

}  // namespace clerestory
