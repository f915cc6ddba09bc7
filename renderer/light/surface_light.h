// Light that reaches the surfaces of a scene from everything but its punctual lights: what of the
// environment is not hidden, emissive surfaces, and what other surfaces send back. One value for
// each vertex of each instance that does not move.
#pragma once

#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace clerestory::light {

// Directions have the axes of the environment map. Shaders read it as two texels of four integers
// (surface_light.glsl).
struct LightValue {
    std::uint32_t halves[8] = {};  // pairs of half floats; see packed()
};
static_assert(sizeof(LightValue) == 32);

// The same with names.
struct LightAtVertex {
    glm::vec3 irradiance{0.0f};  // over pi: radiance of a white diffuse surface
    // Irradiance of a surface with the normal n instead, relative to `irradiance`:
    // max(dot(turned.xyz, n) + turned.w, 0).
    glm::vec4 turned{0.0f, 0.0f, 0.0f, 1.0f};
    // Share of the environment's light from direction w that arrives:
    // clamp(dot(visible.xyz, w) + visible.w, 0, 1).
    glm::vec4 visible{0.0f, 0.0f, 0.0f, 1.0f};
    glm::vec3 nearby{0.0f};  // mean radiance of what hides the environment
};
LightValue packed(const LightAtVertex& light);
LightAtVertex unpacked(const LightValue& value);

inline constexpr std::int32_t kNoLight = INT32_MIN;

// A value is a snapshot: light that is computed further is another object with a higher revision.
struct SurfaceLight {
    std::uint64_t key = 0;  // of everything that the light depends on
    std::uint32_t revision = 0;
    double share = 0.0;  // of the computation that is completed, 0..1
    // The scene with refined meshes, to which the values belong.
    std::shared_ptr<const Scene> scene;
    // The value of vertex v of an instance is values[firstOfInstance[instance] + v]; kNoLight if it
    // has none and shows values[0], the light of an open environment.
    std::vector<std::int32_t> firstOfInstance;
    std::vector<LightValue> values;
};

}  // namespace clerestory::light
