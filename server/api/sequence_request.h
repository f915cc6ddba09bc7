// What a sequence is asked for: what all its frames have in common, and what each has of its own.
#pragma once

#include "plan/request/camera_path.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

namespace clerestory {

// A file of every frame for each that is on.
struct SequenceChannels {
    bool color = true, depth = false, normal = false, objectId = false, through = false;
};

// As the body is written; sequenceFrom() makes whole frames of it.
struct SequenceRequest {
    FrameRequest common;
    std::vector<FrameRequest> frames;
    std::optional<CameraPath> path;
    SequenceChannels channels;
    std::uint32_t first = 0;
};

inline constexpr std::size_t kMaxSequenceFrames = 100'000;

template <class V>
void fields(SequenceChannels& c, V&& visit) {
    visit("color", c.color, Flag{}, "in the format of output");
    visit("depth", c.depth, Flag{}, "metres along -Z, as float32");
    visit("normal", c.normal, Flag{}, "world, as float32");
    visit("objectId", c.objectId, Flag{}, "which thing each pixel shows, as float32");
    visit("through", c.through, Flag{}, "through what each pixel is seen, as float32");
}

template <class V>
void fields(SequenceRequest& s, V&& visit) {
    visit("common", s.common, Nested{}, "a frame's fields, for all frames");
    visit("frames", s.frames, NestedList{kMaxSequenceFrames},
          "each frame's own fields; each replaces the common one of its name whole");
    visit("path", s.path, Nested{}, "instead of frames: a camera that moves between key poses");
    visit("channels", s.channels, Nested{}, "the files of every frame");
    visit("first", s.first, Range{0, kMaxSequenceFrames - 1},
          "the frame to begin with, to go on where an answer broke off");
}

// Of the common fields' text in all frames together: what checking a sequence may take.
inline constexpr std::size_t kMaxSequenceText = 256 * 1024 * 1024;

struct Sequence {
    nlohmann::json common;
    std::vector<nlohmann::json> own;  // each frame's
    SequenceChannels channels;
    std::size_t first = 0;

    std::size_t count() const { return own.size(); }
    // A whole frame: the body of a POST /v1/frames, without the channel.
    nlohmann::json frame(std::size_t index) const;
};

// Throws RequestError (422) that names every wrong field.
Sequence sequenceFrom(const nlohmann::json& body);

nlohmann::json channelsJson(const SequenceChannels& channels);

// JSON Schema (2020-12) of the body.
nlohmann::ordered_json sequenceRequestSchema();

}  // namespace clerestory
