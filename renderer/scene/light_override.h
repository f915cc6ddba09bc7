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

// Without a type: changes the lights of the name `light`, or all without a name. With a type: adds
// a light, which has the name `light`. Of a light's intensity the greatest channel is the scalar
// `intensity` here, and the rest is `color`.
struct LightOverride {
    std::optional<std::string> light;
    std::optional<LightKind> type;
    std::optional<bool> enabled;
    std::optional<glm::dvec3> color;
    std::optional<double> intensity;
    std::optional<glm::dvec3> position, direction;  // world
    std::optional<double> range;
    std::optional<double> innerConeAngle, outerConeAngle;
    std::optional<double> radius;
};

inline constexpr std::size_t kMaxLightOverrides = 64;

template <class O, class V>
requires std::same_as<std::remove_const_t<O>, LightOverride>
void fields(O& o, V&& visit) {
    visit("light", o.light, Text{256},
          "name of the lights to change, absent: all lights; with type: name of the new light");
    visit("type", o.type,
          Choice<LightKind>{{{"point", LightKind::point},
                             {"spot", LightKind::spot},
                             {"directional", LightKind::directional}}},
          "adds a light of this type; absent: changes existing ones");
    visit("enabled", o.enabled, Flag{}, "false: the light is off");
    visit("color", o.color, Range{0, 1e6}, "linear RGB, times intensity; a new light is white");
    visit("intensity", o.intensity, Range{0, 1e9},
          "candela; of a directional light: lux; 1 for a new light. Of an existing light it "
          "replaces the largest channel of colour times intensity");
    visit("position", o.position, Range{-1e9, 1e9, "metres"},
          "position of a point or spot light in the world; the light then does not move with its "
          "node");
    visit("direction", o.direction, Range{-1e9, 1e9},
          "direction in which a spot or directional light shines, in the world");
    visit("range", o.range, Range{0, 1e9, "metres"},
          "distance at which the light ends; 0: unlimited");
    visit("innerConeAngle", o.innerConeAngle, Range{0, 1.5707963, "radians"},
          "angle from the axis of a spot light at which its light begins to fall off; 0 for a new "
          "light");
    visit("outerConeAngle", o.outerConeAngle, Range{0, 1.5707963, "radians"},
          "angle from the axis of a spot light at which its light ends; pi / 4 for a new light");
    visit("radius", o.radius, Range{0, 1e9},
          "radius of the emitting sphere, metres; of a directional light: at a distance of one "
          "metre (the sun: 0.0047); 0: shadows have sharp edges");
}

// Checks that the names exist in the scene or were added before, that new lights have a place and a
// direction, and that directions and cones are valid. `pointer` is the JSON Pointer of the list.
std::vector<FieldError> problems(const Scene& scene, const std::vector<LightOverride>& overrides,
                                 const std::string& pointer = "/lights");

// The lights with the overrides applied in order, then the added ones. A name that no light has is
// no error. Lights that are off have zero intensity.
std::vector<Light> lightsWith(std::vector<Light> lights,
                              const std::vector<LightOverride>& overrides);

// One sentence for each entry, such as "light key: added, spot".
std::vector<std::string> explained(const std::vector<LightOverride>& overrides);

}  // namespace clerestory
