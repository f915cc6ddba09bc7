// What will be done for one frame, before doing it: targets, passes, draws, and a reason for
// everything done and everything left out. Plain values; comparable, printable, no OpenGL.
#pragma once

#include "plan/frame_request.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
    std::uint32_t reflection = kNoReflection;  // into Pass::reflections
    std::uint32_t through = 0;                 // what that channel writes; see Through
    LightList lights;
    bool operator==(const Draw&) const = default;
};

using TargetId = std::uint32_t;
inline constexpr TargetId kNoTarget = 0xffffffffu;
enum class TargetKind { plane, cube };
enum class Format { rgba16f, rgba32f, srgba8 };
struct TargetSpec {
    std::string name;
    TargetKind kind = TargetKind::plane;
    Format format = Format::rgba16f;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t levels = 1;
    std::uint32_t samples = 1;
    bool depth = false;
    std::uint64_t residentKey = 0;  // not 0: its content outlives the frame under this key
    // Hash of everything the planner looked at to find that key: where it is the same, so is the
    // key, and nothing has to be planned to know it.
    std::uint64_t circumstances = 0;
    bool operator==(const TargetSpec&) const = default;
};

// The numbers of a pass that filters a picture; each kind reads its own.
struct PictureFilter {
    float turn = 0.0f;              // twirl: radians per pixel of distance from the centre
    float radius = 0.0f;            // twirl: pixels; farther out nothing turns
    std::array<float, 9> kernel{};  // convolve: row by row, first row on top
    bool repeat = false;            // convolve: beyond a border lies the opposite one
    float threshold = 0.0f;         // glowBright, glow: radiance
    float share = 0.0f;             // glowUp: of the wider one; glow: of what is bright
    bool operator==(const PictureFilter&) const = default;
};

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

enum class PassKind {
    environment,  // prefilters an environment map into a resident cube
    prefilter,    // the same for a captured cube
    gaussian,     // blurs a stored or captured cube about one of its axes
    levels,       // averages a picture into its smaller levels
    capture,      // one face of a probe's cube: as surface
    mirror,       // what a flat mirror shows: as surface, from the mirrored eye
    surface,      // draws the scene from one view: depth, opaque, masked, sky, blended
    backFaces,    // the far sides of solid glass, as normals and distances
    backdrop,     // copies what lies behind glass, before the glass is drawn
    glass,     // draws a layer of glass over what its backdrop holds, then what is blended over it
    channel,   // draws depth, normals or ids instead of colour
    twirl,     // turns a picture about its centre
    convolve,  // weighs each pixel with its eight neighbours
    glowBright,  // what is bright in a picture, half as large
    glowDown,    // the same half as large again
    glowUp,      // adds a wider spread to the next narrower one
    glow,        // puts spread light back into the picture it came from
    toneMap,     // linear radiance -> display colour
    edgeFilter,  // smooths edges of the display colour
};
enum class Effect { base, emission, refraction, planarReflection, environmentReflection, filters };

struct Pass {
    PassKind kind = PassKind::surface;
    std::string name;
    std::string map;  // environment: the name of the map it prefilters
    Effect effect = Effect::base;
    std::uint32_t generation = 0;
    TargetId target = kNoTarget;
    std::uint32_t face = 0;  // of a cube target
    std::vector<TargetId> reads;
    TargetId environment = kNoTarget;  // one of `reads`: the prefiltered map that lights the draws
    TargetId backdrop = kNoTarget;     // one of `reads`: what glass is seen against
    TargetId backFaces = kNoTarget;    // one of `reads`: where solid glass ends
    std::vector<View> views;
    std::vector<ReflectedPicture> reflections;  // Draw::reflection chooses among them
    // In drawing order. depthDraws are those of the opaque draws, not masked, that hide much of the
    // others; empty when a depth prepass would not pay.
    std::vector<Draw> depthDraws;
    std::vector<Draw> opaqueDraws;   // masked ones last
    std::vector<Draw> blendedDraws;  // far to near
    bool sky = false;
    PictureFilter filter;
    MapBlur blur;            // gaussian: in all
    std::uint32_t axis = 0;  // gaussian: 0 to 2, of the cube
    std::string reason;
    bool operator==(const Pass&) const = default;
};

// How a reflector or a piece of glass is served.
enum class Method {
    environment,  // by the environment map
    probe,        // by a captured cube
    mirror,       // by a picture from the mirrored eye
    backdrop,     // glass: by a copy of what was drawn behind it
    traced,       // by rays through the mesh
};
struct Candidate {
    Method method = Method::environment;
    double milliseconds = 0.0;  // predicted; see plan/cost.h
    double error = 0.0;         // predicted relative RMSE on the surface's pixels
    bool operator==(const Candidate&) const = default;
};
// A decision of the planner: what there was to choose from, and what was taken.
struct Decision {
    std::string name;
    Effect effect = Effect::base;
    std::uint32_t generation = 0;
    double share = 0.0;  // of the frame that it covers, about
    Method taken = Method::environment;
    std::vector<Candidate> candidates;
    std::string reason;
    bool operator==(const Decision&) const = default;
};

struct Skipped {
    std::string name;
    Effect effect = Effect::base;
    std::string reason;
    bool operator==(const Skipped&) const = default;
};

struct PlanTotals {
    std::uint64_t passes = 0, views = 0, draws = 0, triangles = 0;
    bool operator==(const PlanTotals&) const = default;
};

struct FramePlan {
    std::vector<TargetSpec> targets;
    std::vector<Pass> passes;
    std::vector<Skipped> skipped;
    std::vector<Decision> decisions;
    std::vector<PlacedLight> lights;
    std::vector<Material> materials;  // the frame's own; their indices follow those of the scene's
    TargetId output = kNoTarget;

    // Read by the passes: everything of the request that reaches the GPU as a number.
    std::uint32_t width = 0, height = 0;
    Channel channel = Channel::color;
    ToneMap toneMap = ToneMap::neutral;
    float exposureFactor = 1.0f;
    std::uint32_t anisotropy = 1;
    std::string environment;  // name of the map
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    std::uint32_t environmentSamples = 64, probeSamples = 32, curvedSamples = 0;
    // For rays, where some draw follows any: the materials of all instances as in Dressing, the
    // union of what their surfaces ask of a shader, and how often a ray turns.
    std::vector<Index> materialOfInstance;
    Features hitFeatures = 0;
    std::uint32_t bounces = 0;
    double perMetre = 1.0;  // 1 / diagonal of the scene: pictures keep distances as shares of it

    bool operator==(const FramePlan&) const = default;
};

// The frame's own view, as requested: of the last pass that draws the scene for the output. Null
// for a plan without one.
const View* frameView(const FramePlan& plan);

// Whether some draw follows rays.
bool traces(const Pass& pass);

PlanTotals totals(const Pass& pass);
PlanTotals totals(const FramePlan& plan);

// One line a pass and one a thing left out; for people and for test messages.
std::string toText(const FramePlan& plan);

std::string_view nameOf(PassKind kind);
std::string_view nameOf(Effect effect);
std::string_view nameOf(Format format);
std::string_view nameOf(Method method);

}  // namespace clerestory
