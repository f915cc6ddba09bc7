// The parts of a pass that draws the scene: a view, lights, draws, and the pictures that surfaces
// reflect. World units are metres; directions and positions are in world space unless stated.
#pragma once

#include "plan/graph/target.h"
#include "scene/scene.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace clerestory {

// A camera of any kind. Double precision: shaders work relative to the eye and never receive a
// world coordinate, so that a scene far from the origin keeps its precision.
struct View {
    glm::dmat4 viewFromWorld{1.0};  // rigid; of a mirrored view, times one reflection
    // Depth is reversed: 1 at znear, 0 at zfar or infinity, w > 0 in front. See gl::deviceClip().
    glm::dmat4 clipFromView{1.0};
    glm::dvec3 eye{0.0};  // world
    bool orthographic = false;
    bool mirrored = false;  // left-handed: front faces are clockwise
    bool lasting = false;   // its picture outlives the frame: nothing in it follows the camera
    double znear = 0.1;
    // Only points p with dot(xyz, p) + w >= 0 are drawn; p is relative to the eye, in world axes.
    std::optional<glm::dvec4> clipPlane;
    bool operator==(const View&) const = default;
};

// What the requested view shows where it sees no surface, if that is not the environment map. Seen
// directly and through glass; what mirrors reflect is the map.
struct OwnBackground {
    std::optional<glm::vec3> radiance;  // a uniform one
    // Nothing: the alpha of the target is the share of a pixel that surfaces cover. Only for views
    // without glass, which reads distances in alpha.
    bool coverage = false;

    bool replacesMap() const { return radiance.has_value() || coverage; }
    bool operator==(const OwnBackground&) const = default;
};

// A picture of a part of what a directional light reaches, with smaller texels. Its view differs
// from that of the whole in the rectangle that it shows.
struct NearShadow {
    TargetRect tile;
    View view;
    bool operator==(const NearShadow&) const = default;
};
inline constexpr std::size_t kMaxNearShadows = 3;
// The extent of a texel: of a picture from a point, at a metre.
inline double texelOf(const View& picture, const TargetRect& tile) {
    const double extent = 2.0 / picture.clipFromView[0][0] / tile.width;
    return std::max(extent, 2.0 / picture.clipFromView[1][1] / tile.height);
}

// Where the shadows of a light are in the shadow map of the plan.
struct LightShadow {
    // One picture of all that the light reaches, or the six faces of a cube about it, in the order
    // of cubeFaceViews() and with the axes of the environment map, three in a row.
    enum class Kind : std::uint32_t { one, six };
    Kind kind = Kind::one;
    TargetRect tile;                 // of the (first) picture
    View view;                       // of the (first) picture
    std::vector<NearShadow> nearer;  // the finest last, at most kMaxNearShadows
    bool operator==(const LightShadow&) const = default;
};

// A light with its world transform applied. Draw::lights holds indices of these.
struct PlacedLight {
    LightKind kind = LightKind::point;
    glm::dvec3 position{0.0};
    glm::vec3 toLight{0.0f, 1.0f, 0.0f};  // directional: towards the light; spot: against its axis
    glm::vec3 intensity{0.0f};            // point, spot: per steradian; directional: irradiance
    float range = 0.0f;                   // 0: unlimited
    float cosInner = 1.0f;
    float cosOuter = 0.0f;
    float radius = 0.0f;                // as Light::radius
    std::optional<LightShadow> shadow;  // none: nothing hides the light
    bool operator==(const PlacedLight&) const = default;
};

inline bool hasRoundLight(std::span<const PlacedLight> lights) {
    return std::any_of(lights.begin(), lights.end(),
                       [](const PlacedLight& light) { return light.radius > 0.0f; });
}

// Feature bits are shared with the shaders: shaders/include/features.glsl. FEATURE_ bits are the
// lower half, LAYER_ bits the upper one.
using Features = std::uint64_t;

inline constexpr std::uint32_t kMaxLightsPerDraw = 16;
inline constexpr std::uint32_t kMaxLights = 256;
struct LightList {
    std::uint32_t count = 0;
    std::array<std::uint8_t, kMaxLightsPerDraw> indices{};
    bool operator==(const LightList&) const = default;
};

// Values of the channel `through`; 0 is the background.
enum Through : std::uint32_t {
    throughDirect = 1,
    throughGlass = 2,
    throughCubeOrRays = 3,    // a mirror drawn from a captured cube or by ray tracing
    throughEnvironment = 4,   // a mirror that shows the environment map only
    throughFirstMirror = 16,  // + k: the plan's k-th mirrored view
};

inline constexpr std::uint32_t kNoReflection = 0xffffffffu;

// Which triangles of a two-sided surface a draw shows.
enum class DrawnFaces : std::uint8_t { both, front, back };

struct Draw {
    std::uint32_t instance = 0;
    Index material = 0;            // of the scene's materials, then of FramePlan::materials
    std::uint32_t firstIndex = 0;  // into Scene::indices
    std::uint32_t indexCount = 0;
    Features features = 0;
    std::uint32_t reflection = kNoReflection;  // into the pass's reflections
    // What a channel of labels shows; none: instance + 1. Of the channel `through`: see Through.
    std::optional<std::uint32_t> label;
    // Of solid glass in a DrawShadowTint: distance of its middle from the light, metres; of a light
    // with a direction, along that from the view's eye.
    std::optional<float> middle;
    LightList lights;
    Primitive primitive = Primitive::triangles;
    DrawnFaces faces = DrawnFaces::both;
    float pointSize = 1.0f;  // width of lines and points, pixels of the target
    bool operator==(const Draw&) const = default;
};
// Returns true if the shader of the draw traces rays.
bool followsRays(const Draw& draw);

// A picture that a surface reflects instead of the environment map of the plan.
struct ReflectedPicture {
    TargetId target = kNoTarget;
    // The picture of a flat mirror is a part of the view's picture, drawn from the mirrored eye:
    // the pixel of the view with its centre at p (from the lower left) is at scale * (p - origin)
    // in the target.
    glm::dvec2 origin{0.0};
    double scale = 1.0;
    double pixelsPerSlope = 1.0;  // pixels of the target per unit of x / z, at the picture's centre
    glm::dvec3 normal{0.0};       // of the mirror, world, towards the eye
    std::uint32_t samples = 1;    // directions averaged in a rough mirror
    // Of a captured cube, which has the axes of the environment map.
    glm::dvec3 center{0.0};                   // world
    glm::dvec3 proxyMin{0.0}, proxyMax{0.0};  // box for parallax correction, relative to center
    glm::dmat3 ownFromMap{1.0};  // of a stored map: its axes from those of the plan's map
    bool operator==(const ReflectedPicture&) const = default;
};

}  // namespace clerestory
