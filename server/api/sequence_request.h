// The request for a sequence: fields that all frames share, and fields of each frame.
#pragma once

#include "plan/visibility/camera_path.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace clerestory {

// The channels of which each frame has a file.
struct SequenceChannels {
    bool color = true, depth = false, normal = false, position = false, albedo = false;
    bool objectId = false, materialId = false, classId = false, through = false;
    bool flow = false, flowBack = false, instances = false;
};

// Layers other than direct of which the channels that have layers have files, too.
struct SequenceLayers {
    bool reflected = false, refracted = false;
};

// A camera that turns about the selection of CameraRequest::fit, at one time of the animation.
struct Turntable {
    double seconds = 8.0;
    double turns = 1.0;  // negative: in the opposite direction
    double frameRate = 30.0;
};

// The body of the request; sequenceFrom() makes complete frames from it, and leaves out `frames`:
// together they would take a kilobyte each.
struct SequenceRequest {
    FrameRequest common;
    std::vector<FrameRequest> frames;
    std::optional<CameraPath> path;
    std::optional<Turntable> turntable;
    std::optional<double> frameRate;  // of a film of frames
    SequenceChannels channels;
    SequenceLayers layers;
    std::uint32_t first = 0;
    std::optional<std::uint32_t> count;  // none: all that follow
    bool plans = true;
};

inline constexpr std::size_t kMaxSequenceFrames = kMaxJsonElements;

// The content types of an answer.
inline constexpr const char* kTarType = "application/x-tar";
inline constexpr const char* kMultipartType = "multipart/mixed; boundary=clerestory-sequence";

template <class V>
void fields(SequenceChannels& c, V&& visit) {
    visit("color", c.color, Flag{}, "color, in the format of output");
    visit("depth", c.depth, Flag{}, "distance along -Z in metres, as float32");
    visit("normal", c.normal, Flag{}, "normals in world space, as float32");
    visit("position", c.position, Flag{}, "positions in the world, as float32");
    visit("albedo", c.albedo, Flag{}, "linear base colours, as float32");
    visit("objectId", c.objectId, Flag{}, "instance + 1 of each pixel, as float32");
    visit("materialId", c.materialId, Flag{},
          "index in the scene's list of materials + 1, as float32");
    visit("classId", c.classId, Flag{}, "class by output.classes of each pixel, as float32");
    visit("through", c.through, Flag{},
          "how each pixel is seen (output.channel through), as float32");
    visit("flow", c.flow, Flag{},
          "output.channel flow to the next frame, as float32; the last frame has none");
    visit("flowBack", c.flowBack, Flag{},
          "the same to the previous frame; the first frame has none");
    visit("instances", c.instances, Flag{},
          "boxes and pixel counts of instances (output.channel instances), as JSON");
}

template <class V>
void fields(SequenceLayers& l, V&& visit) {
    visit("reflected", l.reflected, Flag{}, "what mirrors and glass reflect");
    visit("refracted", l.refracted, Flag{}, "what is seen through glass");
}

template <class V>
void fields(Turntable& t, V&& visit) {
    visit("seconds", t.seconds, Range{0.001, 3600, "seconds"}, "length of the film");
    visit("turns", t.turns, Range{-1000, 1000},
          "turns of the camera about +Y, from +Z towards +X; with a whole number, the frame after "
          "the last one would equal the first");
    visit("frameRate", t.frameRate, Range{0.001, 1000}, "frames per second");
}

template <class V>
void fields(SequenceRequest& s, V&& visit) {
    visit("common", s.common, Nested{}, "fields of all frames");
    visit("frames", s.frames, NestedList{kMaxSequenceFrames},
          "fields of each frame; a field replaces the whole field of that name in common");
    visit("path", s.path, Nested{}, "camera that moves between key poses; instead of frames");
    visit("turntable", s.turntable, Nested{},
          "camera that turns about the selection of common.camera.fit, or about the whole scene; "
          "instead of frames");
    visit("frameRate", s.frameRate, Range{0.001, 1000},
          "frames per second of a film (Accept: video/mp4 or image/webp) of frames; path and "
          "turntable have their own");
    visit("channels", s.channels, Nested{}, "the files that are written for each frame");
    visit("layers", s.layers, Nested{},
          "further layers (output.layer) of which the channels other than color and through have "
          "files if channels has them");
    visit("first", s.first, Range{0, kMaxSequenceFrames - 1},
          "index of the first frame to send, to continue an interrupted answer");
    visit("count", s.count, Range{1, kMaxSequenceFrames},
          "number of frames to send; all that follow when absent");
    visit("plans", s.plans, Flag{},
          "plans and milliseconds in the JSON files; without them equal requests give equal bytes");
}

// Limit of the size of the common fields times the number of frames: bounds the work of joining
// them for the frames that are drawn.
inline constexpr std::size_t kMaxSequenceText = 256 * 1024 * 1024;

struct Sequence {
    // Parts of the client's body, checked; as JSON because a field of `own` replaces the whole
    // field of that name in `common`.
    nlohmann::json common;
    std::vector<nlohmann::json> own;  // of each frame; of a path: time and camera
    SequenceChannels channels;
    SequenceLayers layers;
    std::size_t first = 0, end = 0;   // frames to send: first to end - 1
    bool plans = true;                // in the JSON files, with milliseconds
    std::optional<double> frameRate;  // of a film; none: frames without one

    std::size_t count() const { return own.size(); }  // of all frames
    // A whole frame, with the format of colour.
    FrameRequest request(std::size_t index) const;
};

// Throws RequestError (422) that lists every wrong field.
Sequence sequenceFrom(nlohmann::json body);

// The switches of one of the two.
nlohmann::json switchesJson(const SequenceChannels& channels);
nlohmann::json switchesJson(const SequenceLayers& layers);

// JSON Schema (2020-12) of the body.
nlohmann::ordered_json sequenceRequestSchema();

}  // namespace clerestory
