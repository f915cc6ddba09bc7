// What the client wants: a plain value. Ranges, defaults and words for every field stand in one
// table per struct, fields(), which reading, checking, the schema, the page and the documents walk.
#pragma once

#include "plan/request/filter_request.h"
#include "scene/fields.h"
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
#include <vector>

namespace clerestory {

// ---- the request ---------------------------------------------------------------------------

enum class Convention { opengl, opencv };
enum class PixelCenter { half, integer };
enum class ToneMap { neutral, aces, linear };
enum class OutputFormat { jpeg, png, npy, exr };
enum class Subsampling { s420, s444 };
enum class Channel { color, depth, normal, objectId, through };
enum class Preset { draft, standard, fine };
// How an effect is served. automatic: the cheapest way that meets the preset's accuracy.
enum class PlanarMethod { automatic, environment, mirror, traced };
enum class CurvedMethod { automatic, environment, probe, traced };
enum class GlassMethod { automatic, environment, backdrop, traced };
enum class Parallax { none, box, depth };

struct Intrinsics {  // pixels, first row on top
    double fx = 1000, fy = 1000, cx = 640, cy = 360;
    PixelCenter pixelCenter = PixelCenter::half;
};

struct CameraRequest {
    std::optional<glm::dvec3> position;
    std::optional<glm::dvec3> target;
    std::optional<glm::dvec3> up;
    std::optional<std::array<double, 4>> orientation;     // x y z w
    std::optional<std::array<double, 16>> cameraToWorld;  // column-major
    Convention convention = Convention::opengl;
    std::optional<std::string> name;
    std::optional<double> yfov;
    std::optional<Intrinsics> intrinsics;
    std::optional<double> znear;
    std::optional<double> zfar;
};

struct Effects {
    bool emission = true;
    bool refraction = true;
    bool planarReflection = true;
    bool environmentReflection = true;
};

struct Accuracy {
    Preset preset = Preset::standard;
    std::uint32_t samples = 1;              // coverage samples a pixel
    bool edgeFilter = true;                 // smooth edges after tone mapping
    std::uint32_t anisotropy = 1;           // texture footprint ratio
    std::uint32_t environmentSize = 128;    // edge of a prefiltered environment face
    std::uint32_t environmentSamples = 64;  // GGX samples a texel of it
    PlanarMethod planar = PlanarMethod::automatic;
    CurvedMethod curved = CurvedMethod::automatic;
    GlassMethod glass = GlassMethod::automatic;
    bool backFaces = false;    // solid glass ends where its back is, not where a ball's would
    double planarScale = 1.0;  // pixels of a mirror's picture for each pixel, along an edge
    std::uint32_t planarSamples = 1;  // directions a rough flat mirror adds up; 1: by level
    std::uint32_t generations = 2;    // reflections in reflections; 1: of what does not reflect
    std::uint32_t probeSize = 256;    // edge of a captured face
    std::uint32_t probeSamples = 32;  // GGX samples a texel of it; 1: plain levels
    std::uint32_t curvedSamples = 0;  // directions a rough mirror at a grazing angle adds up
    Parallax parallax = Parallax::box;
    std::uint32_t bounces = 4;  // turns of a traced ray before the environment ends it
    // A budget stands instead of every knob above: the scene's measured curve picks them. Whoever
    // draws or plans is given what was picked, never a budget; see comparison/curve.h.
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

struct Output {
    OutputFormat format = OutputFormat::jpeg;
    std::uint32_t quality = 85;
    Subsampling subsampling = Subsampling::s420;
    Channel channel = Channel::color;
};

struct FrameRequest {
    std::string scene;  // empty: the server's default
    CameraRequest camera;
    std::uint32_t width = 1280;
    std::uint32_t height = 720;
    double time = 0.0;
    std::optional<std::string> clip;  // none: those of defaultClips(); empty: as the file has it
    Effects effects;
    Accuracy accuracy;
    EnvironmentRequest environment;
    std::vector<MaterialOverride> overrides;  // in order; a later one wins
    std::vector<FilterRequest> filters;       // on the finished picture, in order
    ToneMap toneMap = ToneMap::neutral;
    double exposure = 0.0;  // stops
    Output output;
};

inline constexpr std::uint32_t kMaxEdge = 4096;
inline constexpr std::uint64_t kMaxPixels = 8'847'360;  // 4096 x 2160

// ---- the field tables ----------------------------------------------------------------------

template <class V>
void fields(Intrinsics& i, V&& visit) {
    visit("fx", i.fx, Range{1e-3, 1e7, "pixels"}, "focal length along x in pixels");
    visit("fy", i.fy, Range{1e-3, 1e7, "pixels"}, "focal length along y in pixels");
    visit("cx", i.cx, Range{-1e6, 1e6, "pixels"}, "principal point, pixels from the left edge");
    visit("cy", i.cy, Range{-1e6, 1e6, "pixels"}, "principal point, pixels from the top edge");
    visit("pixelCenter", i.pixelCenter,
          Choice<PixelCenter>{{{"half", PixelCenter::half}, {"integer", PixelCenter::integer}}},
          "where the first pixel's centre lies: 0.5 or 0");
}

template <class V>
void fields(CameraRequest& c, V&& visit) {
    visit("position", c.position, Range{-1e9, 1e9, "metres"}, "the eye, metres");
    visit("target", c.target, Range{-1e9, 1e9, "metres"}, "the point looked at, metres");
    visit("up", c.up, Range{-1e9, 1e9}, "the direction that is up in the picture");
    visit("orientation", c.orientation, Range{-1e3, 1e3},
          "world from camera, unit quaternion x y z w; the camera looks down its own -Z");
    visit("cameraToWorld", c.cameraToWorld, Range{-1e9, 1e9}, "rigid 4x4 matrix, column-major");
    visit("convention", c.convention,
          Choice<Convention>{{{"opengl", Convention::opengl}, {"opencv", Convention::opencv}}},
          "axes of cameraToWorld: opengl is +Y up looking down -Z, opencv is +Y down looking down "
          "+Z");
    visit("name", c.name, Text{256}, "a camera of the scene");
    visit("yfov", c.yfov, Range{0.0174532925, 3.1241394, "radians"},
          "vertical field of view, radians (1 to 179 degrees)");
    visit("intrinsics", c.intrinsics, Nested{}, "the lens in pixels, instead of yfov");
    visit("znear", c.znear, Range{1e-9, 1e9, "metres"}, "nearest visible distance, metres");
    visit("zfar", c.zfar, Range{1e-9, 1e12, "metres"},
          "farthest visible distance, metres; infinite when absent");
}

template <class V>
void fields(Effects& e, V&& visit) {
    visit("emission", e.emission, Flag{}, "glowing surfaces add their own light");
    visit("refraction", e.refraction, Flag{}, "glass bends and tints what is behind it");
    visit("planarReflection", e.planarReflection, Flag{}, "flat mirrors and glossy floors");
    visit("environmentReflection", e.environmentReflection, Flag{},
          "curved reflectors with their own cube map");
}

inline Choice<Preset> presetChoice() {
    return {{{"draft", Preset::draft}, {"standard", Preset::standard}, {"fine", Preset::fine}}};
}

// How readers of a NestedPreset find its words and what they stand for.
inline Choice<Preset> presetsOf(const Accuracy&) {
    return presetChoice();
}
inline Accuracy ofPreset(const Accuracy&, Preset preset) {
    return accuracyOf(preset);
}

template <class V>
void fields(Accuracy& a, V&& visit) {
    visit("preset", a.preset, presetChoice(), "sets every knob below; knobs given beside it win");
    visit("samples", a.samples, Range{1, 8},
          "coverage samples a pixel; lowered to what the renderer has");
    visit("edgeFilter", a.edgeFilter, Flag{}, "smooths edges after tone mapping");
    visit("anisotropy", a.anisotropy, Range{1, 16},
          "longest texture footprint; lowered to what the renderer has");
    visit("environmentSize", a.environmentSize, Range{16, 1024, "texels"},
          "edge of a prefiltered environment face, texels");
    visit("environmentSamples", a.environmentSamples, Range{1, 1024},
          "GGX samples for each of its texels");
    visit("planar", a.planar,
          Choice<PlanarMethod>{{{"automatic", PlanarMethod::automatic},
                                {"environment", PlanarMethod::environment},
                                {"mirror", PlanarMethod::mirror},
                                {"traced", PlanarMethod::traced}}},
          "flat mirrors show: the environment map, their own mirrored view, or what rays meet");
    visit("curved", a.curved,
          Choice<CurvedMethod>{{{"automatic", CurvedMethod::automatic},
                                {"environment", CurvedMethod::environment},
                                {"probe", CurvedMethod::probe},
                                {"traced", CurvedMethod::traced}}},
          "curved mirrors show: the environment map, their own captured cube, or what rays meet");
    visit("glass", a.glass,
          Choice<GlassMethod>{{{"automatic", GlassMethod::automatic},
                               {"environment", GlassMethod::environment},
                               {"backdrop", GlassMethod::backdrop},
                               {"traced", GlassMethod::traced}}},
          "glass shows: the environment map, the picture behind it, or what rays meet");
    visit("backFaces", a.backFaces, Flag{},
          "solid glass over a backdrop ends where its own back faces are, not as a ball would");
    visit("planarScale", a.planarScale, Range{0.125, 1},
          "edge of a mirror's picture, in the frame's pixels");
    visit("planarSamples", a.planarSamples, Range{1, 64},
          "directions that a rough flat mirror adds up; 1: one blurred look-up");
    visit("generations", a.generations, Range{1, 8}, "depth of reflections in reflections");
    visit("probeSize", a.probeSize, Range{16, 2048, "texels"},
          "edge of a captured cube's face, texels");
    visit("probeSamples", a.probeSamples, Range{1, 1024},
          "GGX samples for each of its texels; 1: plain averages");
    visit("curvedSamples", a.curvedSamples, Range{0, 64},
          "directions that rough metal which mirrors a map adds up where it is seen at a grazing "
          "angle; 0: one blurred look-up");
    visit("parallax", a.parallax,
          Choice<Parallax>{
              {{"none", Parallax::none}, {"box", Parallax::box}, {"depth", Parallax::depth}}},
          "where a captured cube's light is taken to come from: infinity, a box, its own depth");
    visit("bounces", a.bounces, Range{1, 16}, "turns of a traced ray");
    visit("maxMilliseconds", a.maxMilliseconds, Range{1, 60000, "milliseconds"},
          "a budget instead of knobs: the least error that a frame of so many milliseconds has, by "
          "the scene's measured curve");
    visit(
        "maxError", a.maxError, Range{1e-6, 1e3},
        "a budget instead of knobs: the cheapest with at most this relMSE against the path-traced "
        "truth; with maxMilliseconds too, time comes first");
}

template <class V>
void fields(EnvironmentRequest& e, V&& visit) {
    visit("map", e.map, Text{128}, "name of an environment map; the scene's own when absent");
    visit(
        "rotation", e.rotation, Rotation{},
        "world from map: quaternion x y z w, matrix of 9 (column-major), or radians about X, then "
        "Y, then Z; the scene's own when absent");
    visit("intensity", e.intensity, Range{0, 1e4}, "factor on the map's light");
    visit("visible", e.visible, Flag{}, "false: lights the scene but is not drawn behind it");
}

template <class V>
void fields(Output& o, V&& visit) {
    visit("format", o.format,
          Choice<OutputFormat>{{{"jpeg", OutputFormat::jpeg},
                                {"png", OutputFormat::png},
                                {"npy", OutputFormat::npy},
                                {"exr", OutputFormat::exr}}},
          "npy and exr hold float32; their color is linear radiance before tone mapping");
    visit("quality", o.quality, Range{1, 100}, "JPEG quality");
    visit("subsampling", o.subsampling,
          Choice<Subsampling>{{{"4:2:0", Subsampling::s420}, {"4:4:4", Subsampling::s444}}},
          "JPEG chroma");
    visit(
        "channel", o.channel,
        Choice<Channel>{{{"color", Channel::color},
                         {"depth", Channel::depth},
                         {"normal", Channel::normal},
                         {"objectId", Channel::objectId},
                         {"through", Channel::through}}},
        "depth: metres along -Z, 0 where nothing is; normal: world; objectId: instance + 1, 0 "
        "where nothing is; through: 0 nothing, 1 a surface itself, 2 glass, 3 a mirror served by a "
        "captured cube or by rays, 4 a mirror that shows the environment map only, 16 + k the "
        "plan's k-th mirrored picture, from 0");
}

template <class V>
void fields(FrameRequest& r, V&& visit) {
    visit("scene", r.scene, Text{128}, "id of a scene; the server's first when empty");
    visit("camera", r.camera, Nested{}, "pose and lens; the scene's default view when empty");
    visit("width", r.width, Range{1, kMaxEdge, "pixels"}, "pixels");
    visit("height", r.height, Range{1, kMaxEdge, "pixels"}, "pixels");
    visit("time", r.time, Range{0, 1e6, "seconds"},
          "the moment, seconds; beyond a clip's end the clip begins anew");
    visit("clip", r.clip, Text{256},
          "which of the scene's animations plays; absent: the first, and those that move nothing "
          "it moves; empty: none");
    visit("effects", r.effects, Nested{}, "a switch for each effect");
    visit("accuracy", r.accuracy, NestedPreset{}, "a preset's name, or an object of knobs");
    visit("environment", r.environment, Nested{}, "light from all around");
    visit("overrides", r.overrides, NestedList{64},
          "other materials for what a material's or node's name chooses; a later one wins");
    visit("filters", r.filters, NestedUnionList{kMaxFilters, "Filter"},
          "filters on the finished picture, in order: on linear light, before tone mapping; "
          "channels that hold numbers are not filtered");
    visit(
        "toneMap", r.toneMap,
        Choice<ToneMap>{
            {{"neutral", ToneMap::neutral}, {"aces", ToneMap::aces}, {"linear", ToneMap::linear}}},
        "how radiance becomes display colour");
    visit("exposure", r.exposure, Range{-32, 32, "stops"}, "stops");
    visit("output", r.output, Nested{}, "what comes back");
}

// ---- errors --------------------------------------------------------------------------------

// The request names something that is out of range or does not exist. Every wrong field at once.
class InvalidRequest : public std::runtime_error {
public:
    explicit InvalidRequest(std::vector<FieldError> errors);
    const std::vector<FieldError>& errors() const { return errors_; }

private:
    std::vector<FieldError> errors_;
};

// What no single field can know: one pose at most, near before far, pixels in all, a unit
// quaternion, an output format that can hold the channel. Empty when the request is sound.
std::vector<FieldError> problems(const FrameRequest& request);

}  // namespace clerestory
