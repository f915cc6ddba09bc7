// What a frame is answered as: file format, and a channel of colour, geometry or labels.
#pragma once

#include "plan/request/camera_request.h"
#include "scene/classes.h"
#include "scene/fields.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory {

enum class OutputFormat { jpeg, png, npy, exr, webp, json };
enum class Subsampling { s420, s444 };
enum class Channel {
    color,
    depth,
    normal,
    position,
    albedo,
    objectId,
    materialId,
    classId,
    through,
    flow,
    instances
};
// Whether a channel shows surfaces themselves, or what they mirror or let through.
enum class OutputLayer { direct, reflected, refracted };

// The other moment, and place of the camera, of the channel flow.
struct FlowRequest {
    double time = 0.0;
    std::optional<CameraRequest> camera;  // none: that of the frame
};

struct Output {
    OutputFormat format = OutputFormat::jpeg;
    std::uint32_t quality = 85;
    Subsampling subsampling = Subsampling::s420;
    Channel channel = Channel::color;
    OutputLayer layer = OutputLayer::direct;
    std::vector<ClassPattern> classes;  // of the channel classId, in order; the first match wins
    std::optional<FlowRequest> flow;    // of the channel flow
};

// Numbers of a pixel in files of floats.
std::uint32_t channelsOf(Channel channel);
// Whether the channel exists for layers other than direct.
bool hasLayers(Channel channel);

inline constexpr Range kTime{0, 1e6, "seconds"};

template <class V>
void fields(FlowRequest& f, V&& visit) {
    visit("time", f.time, Required{kTime}, "time of the animation in the other frame");
    visit("camera", f.camera, NestedInBody{},
          "camera of the other frame, of the same size; that of this frame when absent");
}

template <class V>
void fields(Output& o, V&& visit) {
    visit("format", o.format,
          Choice<OutputFormat>{{{"jpeg", OutputFormat::jpeg},
                                {"png", OutputFormat::png},
                                {"npy", OutputFormat::npy},
                                {"exr", OutputFormat::exr},
                                {"webp", OutputFormat::webp},
                                {"json", OutputFormat::json}}},
          "file format; npy and exr hold float32, their color is linear radiance before tone "
          "mapping; json holds the channel instances");
    visit("quality", o.quality, Range{1, 100}, "quality factor of JPEG and WebP");
    visit("subsampling", o.subsampling,
          Choice<Subsampling>{{{"4:2:0", Subsampling::s420}, {"4:4:4", Subsampling::s444}}},
          "JPEG chroma subsampling");
    visit("channel", o.channel,
          Choice<Channel>{{{"color", Channel::color},
                           {"depth", Channel::depth},
                           {"normal", Channel::normal},
                           {"position", Channel::position},
                           {"albedo", Channel::albedo},
                           {"objectId", Channel::objectId},
                           {"materialId", Channel::materialId},
                           {"classId", Channel::classId},
                           {"through", Channel::through},
                           {"flow", Channel::flow},
                           {"instances", Channel::instances}}},
          "content of the pixels. depth: metres along -Z, along the ray with the lenses fisheye, "
          "equirectangular and cube, 0 for the background; normal: in world space; "
          "position: in the world, metres; albedo: linear base colour, factor times texture times "
          "vertex colour; objectId: instance + 1; materialId: index in the scene's list of "
          "materials + 1, of an overridden material that of the original one; classId: see "
          "classes; each 0 for the background; through: 0 background, 1 a surface itself, 2 glass, "
          "3 a mirror drawn from a captured cube or by ray tracing, 4 a mirror "
          "that shows the environment map only, 16 + k the plan's k-th mirrored view, from 0; "
          "flow: displacement in pixels, to the right and down, to the same surface point in the "
          "frame of output.flow, and its depth there; all three are 0 without such a point; "
          "instances: boxes and pixel counts of each instance in the frame, instead of pixels");
    visit("layer", o.layer,
          Choice<OutputLayer>{{{"direct", OutputLayer::direct},
                               {"reflected", OutputLayer::reflected},
                               {"refracted", OutputLayer::refracted}}},
          "what the channels other than color and through show. direct: the nearest surface; "
          "reflected: what mirrors and glass reflect; refracted: what is seen through glass; both "
          "in the direction of a perfectly smooth surface with its normal map, by ray tracing, and "
          "0 elsewhere");
    visit("classes", o.classes, NestedList{kMaxClassPatterns},
          "classes of the channels classId and instances, by names of nodes; the first match wins. "
          "Distinct names are numbered from 1 in the order of the list; 0: no match");
    visit("flow", o.flow, Nested{}, "the other frame of the channel flow");
}

}  // namespace clerestory
