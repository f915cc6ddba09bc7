// Light that reaches the surfaces of a scene from everything but its punctual lights: what of the
// environment is not hidden, emissive surfaces, and what other surfaces send back. One value for
// each vertex of each instance that does not move.
#pragma once

#include "light/edge_lengths.h"
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

inline float luminance(const glm::vec3& c) {
    return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

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
    glm::vec2 sides{0.0f};   // see ofBothSides()
};
// A two-sided surface has the light of both sides in one value, whose visible.w is greater by
// kOfSides. `irradiance` is that of the front, turned.xyz that of the back. The share of the
// environment on the front is clamp(sides.x * dot(visible.xyz, w) + visible.w - kOfSides, 0, 1), on
// the back clamp(sides.y * dot(visible.xyz, m) + turned.w, 0, 1), where m is w mirrored in the
// surface: how the share depends on the direction is that of one side, and the other has a part
// of it. `nearby` is for an irradiance of luminance 1, because one side may be far brighter than
// the other, as in a lampshade.
inline constexpr float kOfSides = 4.0f;
struct SideLight {
    glm::vec3 irradiance{0.0f};
    glm::vec4 visible{0.0f};  // as LightAtVertex::visible
};
LightAtVertex ofBothSides(const SideLight& front, const SideLight& back, const glm::vec3& normal,
                          const glm::vec3& nearby);
LightValue packed(const LightAtVertex& light);
LightAtVertex unpacked(const LightValue& value);

// Light of emissive surfaces and of punctual lights in flat mirrors, for specular lobes. Emitters
// that fill a large part of the directions are in `nearby` instead. Of a two-sided surface that of
// its brighter side.
struct EmittersAtVertex {
    glm::vec3 light{0.0f};  // integral of the radiance over directions, over pi
    glm::vec3 flux{0.0f};   // the same of luminance times direction
};
struct EmittersValue {
    std::uint32_t halves[4] = {};
};
static_assert(sizeof(EmittersValue) == 16);
EmittersValue packed(const EmittersAtVertex& emitters);
EmittersAtVertex unpacked(const EmittersValue& value);

// Entries of SurfaceLight::firstOfInstance from kNoLight on are one value for all vertices of an
// instance.
inline constexpr std::int32_t kNoLight = INT32_MIN;  // values[0]
inline constexpr std::int32_t kEndOfConstants = INT32_MIN + (1 << 24);
constexpr bool isConstant(std::int32_t first) {
    return first < kEndOfConstants;
}
constexpr std::uint32_t constantValue(std::int32_t first) {
    return static_cast<std::uint32_t>(first - kNoLight);
}

// Light at points of a regular grid in the world, for what moves through it.
struct LightGrid {
    glm::dvec3 first{0.0};    // the first point
    glm::dvec3 spacing{1.0};  // metres
    glm::uvec3 count{0u};     // points along each axis; x varies fastest
    std::vector<LightValue> values;

    std::size_t points() const { return std::size_t{count.x} * count.y * count.z; }
    glm::dvec3 point(std::size_t i) const;
};
// Centres of about so many equal cells of the bounds.
LightGrid gridOver(const Bounds& bounds, std::uint32_t cells);
// Between the eight points around; beyond the grid that of its border. The grid is not empty.
LightAtVertex lightAt(const LightGrid& grid, const glm::dvec3& position);

// A value is a snapshot: light that is computed further is another object with a higher revision.
struct SurfaceLight {
    std::uint64_t key = 0;  // of everything that the light depends on
    std::uint32_t revision = 0;
    double share = 0.0;  // of the computation that is completed, 0..1
    // The scene with refined meshes, to which the values belong.
    std::shared_ptr<const Scene> scene;
    EdgeLengths edges;  // with which they were refined
    // The value of vertex v of an instance is values[firstOfInstance[instance] + v], or one for all
    // vertices; see isConstant(). values[0] is the light of an open environment. Instance moving[i]
    // has values[1 + i], which depends on the pose: lightOfMoving().
    std::vector<std::int32_t> firstOfInstance;
    std::vector<std::uint32_t> moving;
    std::vector<LightValue> values;
    std::vector<EmittersValue> emitters;  // as many, or none without emitters
    LightGrid grid;                       // empty if nothing moves
};

// The values of SurfaceLight::moving in a pose of its scene: those of the grid at the centres of
// their bounds.
std::vector<LightValue> lightOfMoving(const SurfaceLight& light, const Pose& pose);

}  // namespace clerestory::light
