// What a pass that draws the scene consists of: a view, lights, draws, and the pictures that
// surfaces mirror.
#pragma once

#include "plan/graph/target.h"
#include "scene/scene.h"

#include <array>
#include <cstdint>
#include <optional>

namespace clerestory {

// A place the scene is drawn from. Double, because the shaders work relative to the eye:
// they never see a world coordinate, so a scene far from the origin keeps its precision.
struct View {
    glm::dmat4 viewFromWorld{1.0};  // rigid (mirrored: times one reflection)
    // Depth is reversed: 1 at znear, 0 at zfar or infinity, w > 0 in front. See gl::clipConvention.
    glm::dmat4 clipFromView{1.0};
    glm::dvec3 eye{0.0};  // world
    bool orthographic = false;
    bool mirrored = false;  // left-handed: front faces turn clockwise
    double znear = 0.1;
    // Nothing on the far side of it is drawn: kept are points p with dot(xyz, p) + w >= 0, where p
    // is relative to the eye, in the world's axes.
    std::optional<glm::dvec4> clipPlane;
    bool operator==(const View&) const = default;
};

// A light as the shaders see it: placed in the world. Draw::lights holds indices of these.
struct PlacedLight {
    LightKind kind = LightKind::point;
    glm::dvec3 position{0.0};
    glm::vec3 toLight{0.0f, 1.0f, 0.0f};  // directional: towards the light; spot: against its axis
    glm::vec3 intensity{0.0f};            // point, spot: per steradian; directional: irradiance
    float range = 0.0f;                   // 0: unlimited
    float cosInner = 1.0f;
    float cosOuter = 0.0f;
    bool operator==(const PlacedLight&) const = default;
};

// Feature bits are shared with the shaders: shaders/include/features.glsl.
using Features = std::uint32_t;

inline constexpr std::uint32_t kMaxLightsPerDraw = 16;
inline constexpr std::uint32_t kMaxLights = 256;
struct LightList {
    std::uint32_t count = 0;
    std::array<std::uint8_t, kMaxLightsPerDraw> indices{};
    bool operator==(const LightList&) const = default;
};

// What a surface is seen as, in the channel of that name; 0 is where nothing is.
enum Through : std::uint32_t {
    throughDirect = 1,
    throughGlass = 2,
    throughCubeOrRays = 3,    // a mirror, served by a captured cube or by rays
    throughEnvironment = 4,   // a mirror that shows no more than an environment map
    throughFirstMirror = 16,  // and those after it: the mirrored pictures in the plan's order
};

inline constexpr std::uint32_t kNoReflection = 0xffffffffu;
struct Draw {
    std::uint32_t instance = 0;
    Index material = 0;            // of the scene's materials, then of FramePlan::materials
    std::uint32_t firstIndex = 0;  // into Scene::indices
    std::uint32_t indexCount = 0;
    Features features = 0;
    std::uint32_t reflection = kNoReflection;  // into the pass's reflections
    std::uint32_t through = 0;                 // what that channel writes; see Through
    LightList lights;
    bool operator==(const Draw&) const = default;
};
// Whether its shader follows rays.
bool followsRays(const Draw& draw);

// Light that a surface mirrors from a picture drawn for it, instead of from the environment map.
struct ReflectedPicture {
    TargetId target = kNoTarget;
    // A flat mirror's picture is a part of the view's, seen from the mirrored eye: a pixel of the
    // view at p (its centre, from the lower left) lies at scale * (p - origin) in the target.
    glm::dvec2 origin{0.0};
    double scale = 1.0;
    double pixelsPerSlope = 1.0;  // of the target, at the picture's centre
    glm::dvec3 normal{0.0};       // of the mirror, world, towards the eye
    std::uint32_t samples = 1;    // directions that a rough mirror adds up
    // A probe's cube has the environment map's axes.
    glm::dvec3 center{0.0};                   // world
    glm::dvec3 proxyMin{0.0}, proxyMax{0.0};  // box it was drawn in; world, about its centre
    glm::dmat3 ownFromMap{1.0};  // of a stored map: its own axes from those of the plan's map
    bool operator==(const ReflectedPicture&) const = default;
};

}  // namespace clerestory
