// The request for a frame as a plain value. Each struct has one field table, fields(), with the
// range and description of every field; the reader, the checks, the schema, the page and
// docs/api.md use it.
#pragma once

#include "plan/request/camera_request.h"
#include "plan/request/filter_request.h"
#include "plan/request/output_request.h"
#include "plan/request/tone_map.h"
#include "scene/compose.h"
#include "scene/fields.h"
#include "scene/ground.h"
#include "scene/join.h"
#include "scene/light_override.h"
#include "scene/material_override.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace clerestory {

// ---- the request ---------------------------------------------------------------------------

enum class Preset { draft, standard, fine };
enum class Background { map, transparent };
// Techniques for an effect. automatic: the cheapest one that is accurate enough for the preset.
enum class PlanarMethod { automatic, environment, mirror, traced };
enum class CurvedMethod { automatic, environment, probe, traced };
enum class GlassMethod { automatic, environment, backdrop, traced };
enum class Parallax { none, box, depth };

struct Effects {
    bool emission = true;
    bool refraction = true;
    bool planarReflection = true;
    bool environmentReflection = true;
    bool materialLayers = true;
    bool shadows = true;
    bool indirectLight = true;
};

struct Accuracy {
    Preset preset = Preset::standard;
    std::uint32_t samples = 1;              // of a pixel where the picture has contrast
    double sampleShare = 0.25;              // greatest share of the pixels with several samples
    bool emitterCoverage = true;            // small glowing surfaces by their share of a pixel
    bool edgeFilter = true;                 // smooth edges after tone mapping
    std::uint32_t anisotropy = 1;           // texture footprint ratio
    std::uint32_t environmentSize = 128;    // edge of a face of the prefiltered environment map
    std::uint32_t environmentSamples = 64;  // GGX samples per texel of it
    PlanarMethod planar = PlanarMethod::automatic;
    CurvedMethod curved = CurvedMethod::automatic;
    GlassMethod glass = GlassMethod::automatic;
    bool backFaces = false;    // exit point of solid glass: from its back faces, not from a sphere
    double planarScale = 1.0;  // edge of a mirrored view relative to the frame's
    std::uint32_t planarSamples = 1;  // directions averaged in a rough flat mirror; 1: one lookup
    std::uint32_t generations = 2;    // depth of reflections in reflections
    std::uint32_t probeSize = 256;    // edge of a captured face, texels
    std::uint32_t probeSamples = 32;  // GGX samples per texel of it; 1: averaged mip levels
    std::uint32_t curvedSamples = 4;  // look-ups of a map along a rough lobe at an angle
    Parallax parallax = Parallax::box;
    // Reflections of a traced ray, after which it sees the environment. Faces of glass that the ray
    // crosses count a third, and so do reflections inside it at flat faces.
    std::uint32_t bounces = 4;
    std::uint32_t raySamples = 1;       // paths of a traced ray of a rough mirror
    std::uint32_t glassRaySamples = 4;  // the same through rough glass
    // A budget replaces all fields above, which are chosen from the scene's measured curve. The
    // planner and the renderer never see a budget; see comparison/curve.h.
    std::optional<double> maxMilliseconds;
    std::optional<double> maxError;
    bool isBudget() const { return maxMilliseconds || maxError; }
    bool operator==(const Accuracy&) const = default;
};
Accuracy accuracyOf(Preset preset);

struct EnvironmentRequest {
    std::optional<std::string> map;      // none: the scene's own
    std::optional<Quaternion> rotation;  // world from map; none: the scene's own
    double intensity = 1.0;
    bool visible = true;  // false: the background is black, light stays
};

// What the camera sees where it sees no surface, directly or through glass: the environment map,
// nothing, or a radiance. Mirrors reflect the environment map in all cases.
using BackgroundRequest = std::variant<Background, std::array<double, 3>>;

struct FrameRequest {
    std::string scene;               // empty: the server's default
    std::vector<PlacedScene> parts;  // several scenes in one; `scene` is then the first's id
    CameraRequest camera;
    std::uint32_t width = 1280;
    std::uint32_t height = 720;
    double time = 0.0;
    std::optional<std::string> clip;     // none: defaultClips(); empty: no clip
    std::optional<std::string> variant;  // of the scene's materials; none: the default ones
    double pointSize = 1.0;              // width of lines and points, pixels
    Effects effects;
    Accuracy accuracy;
    EnvironmentRequest environment;
    std::optional<BackgroundRequest> background;  // none: the map
    std::vector<MaterialOverride> overrides;      // in order; a later one wins
    std::vector<NodeOverride> nodes;              // in order; a later one wins
    std::vector<LightOverride> lights;            // in order; a later one wins
    std::optional<GroundPlane> ground;
    std::vector<FilterRequest> filters;  // post-filters, in order
    ToneMap toneMap = ToneMap::neutral;
    double exposure = 0.0;  // stops
    Output output;
};

bool isTransparent(const std::optional<BackgroundRequest>& background);
// What the request changes of its scene.
Composition compositionOf(const FrameRequest& request);

inline constexpr std::uint32_t kMaxEdge = 4096;
inline constexpr std::uint64_t kMaxPixels = 8'847'360;  // 4096 x 2160

// ---- the field tables ----------------------------------------------------------------------

template <class V>
void fields(Effects& e, V&& visit) {
    visit("emission", e.emission, Flag{}, "emitting surfaces add their radiance");
    visit("refraction", e.refraction, Flag{}, "glass refracts and tints what is behind it");
    visit("planarReflection", e.planarReflection, Flag{},
          "flat mirrors and glossy floors reflect the scene");
    visit("environmentReflection", e.environmentReflection, Flag{},
          "curved mirrors reflect the scene");
    visit("materialLayers", e.materialLayers, Flag{},
          "clear coat, sheen, iridescence, anisotropy, diffuse transmission, dispersion");
    visit("shadows", e.shadows, Flag{}, "shadows of punctual lights");
    visit("indirectLight", e.indirectLight, Flag{},
          "surfaces occlude the environment and illuminate each other; computed once in the "
          "background while frames show the completed part, see Clerestory-Light");
}

inline Choice<Preset> presetChoice() {
    return {{{"draft", Preset::draft}, {"standard", Preset::standard}, {"fine", Preset::fine}}};
}

// The names of the presets and their values, for readers of a NestedPreset.
inline Choice<Preset> presetsOf(const Accuracy&) {
    return presetChoice();
}
inline Accuracy ofPreset(const Accuracy&, Preset preset) {
    return accuracyOf(preset);
}

template <class V>
void fields(Accuracy& a, V&& visit) {
    visit("preset", a.preset, presetChoice(),
          "sets every field below; fields that are also present override it");
    visit("samples", a.samples, Range{1, 64},
          "samples of each pixel in which the picture has contrast; other pixels have one");
    visit("sampleShare", a.sampleShare, Range{0.01, 1},
          "greatest share of the pixels that have several samples: those with the most contrast");
    visit(
        "emitterCoverage", a.emitterCoverage, Flag{},
        "small surfaces that emit light count in each pixel with the share that they cover, which "
        "is computed from their triangles");
    visit("edgeFilter", a.edgeFilter, Flag{}, "smooths edges after tone mapping");
    visit("anisotropy", a.anisotropy, Range{1, 16},
          "maximum anisotropy of texture filtering; reduced to what the renderer supports");
    visit("environmentSize", a.environmentSize, Range{16, 1024, "texels"},
          "edge of a face of the prefiltered environment map");
    visit("environmentSamples", a.environmentSamples, Range{1, 1024},
          "GGX samples per texel of the prefiltered environment map");
    visit("planar", a.planar,
          Choice<PlanarMethod>{{{"automatic", PlanarMethod::automatic},
                                {"environment", PlanarMethod::environment},
                                {"mirror", PlanarMethod::mirror},
                                {"traced", PlanarMethod::traced}}},
          "source of reflections in flat mirrors: environment map, mirrored view, or ray tracing; "
          "automatic: by predicted error and time");
    visit("curved", a.curved,
          Choice<CurvedMethod>{{{"automatic", CurvedMethod::automatic},
                                {"environment", CurvedMethod::environment},
                                {"probe", CurvedMethod::probe},
                                {"traced", CurvedMethod::traced}}},
          "source of reflections in curved mirrors: environment map, captured cube (probe), or ray "
          "tracing; automatic: by predicted error and time");
    visit("glass", a.glass,
          Choice<GlassMethod>{{{"automatic", GlassMethod::automatic},
                               {"environment", GlassMethod::environment},
                               {"backdrop", GlassMethod::backdrop},
                               {"traced", GlassMethod::traced}}},
          "source of the light behind glass: environment map, the picture behind it (backdrop), or "
          "ray tracing; automatic: by predicted error and time");
    visit("backFaces", a.backFaces, Flag{},
          "true: the exit point of solid glass over a backdrop comes from its back faces; false: "
          "from a sphere");
    visit("planarScale", a.planarScale, Range{0.125, 1},
          "resolution of mirrored views, relative to the frame");
    visit("planarSamples", a.planarSamples, Range{1, 64},
          "directions averaged in a rough flat mirror; 1: one lookup in a blurred level");
    visit("generations", a.generations, Range{1, 8},
          "depth of reflections in reflections; 1: reflectors seen in reflections show the "
          "environment map");
    visit("probeSize", a.probeSize, Range{16, 2048, "texels"}, "edge of a face of a captured cube");
    visit("probeSamples", a.probeSamples, Range{1, 1024},
          "GGX samples per texel of a captured cube; 1: averaged mip levels");
    visit("curvedSamples", a.curvedSamples, Range{0, 64},
          "look-ups of a map along the lobe of a rough surface that is seen at an angle; 0 or 1: "
          "one");
    visit("parallax", a.parallax,
          Choice<Parallax>{
              {{"none", Parallax::none}, {"box", Parallax::box}, {"depth", Parallax::depth}}},
          "parallax correction of captured cubes: none (infinite distance), a box, or their depth");
    visit("bounces", a.bounces, Range{1, 16},
          "maximum number of reflections of a traced ray; faces of glass that it crosses, and "
          "flat ones that reflect it inside, count a third");
    visit("raySamples", a.raySamples, Range{1, 16},
          "paths for each traced ray of a rough mirror, where the processor follows rays; 1: one "
          "path with a blurred end");
    visit("glassRaySamples", a.glassRaySamples, Range{1, 16},
          "the same for each traced ray through rough glass; with 1, what is near behind the glass "
          "is sharp");
    visit("maxMilliseconds", a.maxMilliseconds, Range{1, 60000, "milliseconds"},
          "budget that replaces the settings: the smallest error within this time, by the measured "
          "curve of the scene");
    visit("maxError", a.maxError, Range{1e-6, 1e3},
          "budget that replaces the settings: the cheapest settings with at most this relMSE "
          "against the path-traced reference; maxMilliseconds has precedence");
}

template <class V>
void fields(EnvironmentRequest& e, V&& visit) {
    visit("map", e.map, Text{128}, "name of an environment map; the scene's own map when absent");
    visit("rotation", e.rotation, Rotation{},
          "rotation from map to world: quaternion x y z w, 3x3 matrix (column-major), or radians "
          "about X, then Y, then Z; the scene's own when absent");
    visit("intensity", e.intensity, Range{0, 1e4}, "factor on the radiance of the map");
    visit("visible", e.visible, Flag{},
          "false: the map lights the scene, and the background is black");
}

template <class V>
void fields(FrameRequest& r, V&& visit) {
    PlacedScenes scenes{r.scene, r.parts};
    visit("scene", scenes, TextOrList{{128}, kMaxPlacedScenes},
          "id of a scene, the server's default scene when empty; or a list of scenes with "
          "transforms");
    visit("camera", r.camera, Nested{}, "pose and lens; the default view of the scene when empty");
    visit("width", r.width, Range{1, kMaxEdge, "pixels"},
          "width of the frame; width times height is at most 8847360");
    visit("height", r.height, Range{1, kMaxEdge, "pixels"}, "height of the frame");
    visit(
        "time", r.time, kTime,
        "time of the animation; at its end a clip shows its last key, after that it starts again");
    visit("clip", r.clip, Text{256},
          "name of the animation that plays; absent: the first one, and each later one that "
          "shares no target with an earlier one; empty: none");
    visit("variant", r.variant, Text{256},
          "name of a material variant of the scene; absent: its default materials");
    visit("pointSize", r.pointSize, Range{1, 64, "pixels"},
          "width of lines and points in the picture that they are drawn into");
    visit("effects", r.effects, Nested{}, "switches of the effects");
    visit("accuracy", r.accuracy, NestedPreset{}, "the name of a preset, or an object of settings");
    visit("environment", r.environment, Nested{}, "environment map that lights the scene");
    visit("background", r.background,
          ChoiceOrNumbers<Background>{
              {{{"map", Background::map}, {"transparent", Background::transparent}}}, {0, 1e4}},
          "what the camera sees where there is no surface, directly or through glass: map, "
          "transparent, or three numbers, a linear radiance; mirrors reflect the map");
    visit("overrides", r.overrides, NestedList{64},
          "changes of the materials that are selected by material or node name; a later entry "
          "overrides earlier ones");
    visit("nodes", r.nodes, NestedList{kMaxNodeOverrides},
          "changes of nodes: hidden, moved or with another material; a later entry "
          "overrides earlier ones");
    visit("lights", r.lights, NestedList{kMaxLightOverrides},
          "lights that are added, changed or switched off; a later entry overrides earlier ones");
    visit("ground", r.ground, Nested{},
          "a ground plane below the scene, with its shadows and reflections");
    visit("filters", r.filters, NestedUnionList{kMaxFilters, "Filter"},
          "post-filters, applied in order to linear light before tone mapping; only the channel "
          "color is filtered");
    visit(
        "toneMap", r.toneMap,
        Choice<ToneMap>{
            {{"neutral", ToneMap::neutral}, {"aces", ToneMap::aces}, {"linear", ToneMap::linear}}},
        "tone mapping operator, from radiance to display colour");
    visit("exposure", r.exposure, Range{-32, 32, "stops"}, "exposure compensation");
    visit("output", r.output, Nested{}, "format and content of the answer");
}

// ---- errors --------------------------------------------------------------------------------

// A field is out of range or names something that does not exist. Lists every wrong field.
class InvalidRequest : public std::runtime_error {
public:
    explicit InvalidRequest(std::vector<FieldError> errors);
    const std::vector<FieldError>& errors() const { return errors_; }

private:
    std::vector<FieldError> errors_;
};

// Checks that involve several fields: at most one pose, near before far, the number of pixels, a
// unit quaternion, an output format that can hold the channel. Empty if the request is valid.
std::vector<FieldError> problems(const FrameRequest& request);

// The errors of a part of a request, which is at `pointer`.
std::vector<FieldError> below(const std::string& pointer, std::vector<FieldError> errors);

}  // namespace clerestory
