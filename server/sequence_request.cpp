#include "server/sequence_request.h"

#include "scene/import/field_reader.h"

namespace clerestory {
namespace {

using nlohmann::json;

json cameraJson(const CameraRequest& camera) {
    FrameRequest frame;
    frame.camera = camera;
    return json::parse(canonicalText(frame)).at("camera");
}

// The frame's own fields, for each frame.
json ownFields(const json& body, const SequenceRequest& request) {
    if (!request.path) return body.value("frames", json::array());
    json list = json::array();
    for (const PathFrame& frame : framesOf(*request.path)) {
        list.push_back({{"time", frame.time}, {"camera", cameraJson(frame.camera)}});
    }
    return list;
}

void append(std::vector<FieldError>& errors, const std::string& pointer,
            const std::vector<FieldError>& more) {
    for (FieldError error : more) {
        error.pointer = pointer + error.pointer;
        errors.push_back(std::move(error));
    }
}

// The rules that bind several fields of the body.
void checkWhole(const json& body, const SequenceRequest& request, std::vector<FieldError>& errors) {
    if (request.path && body.contains("frames")) {
        errors.push_back({"/path", "stands beside frames", "one of the two"});
    }
    if (request.path) {
        append(errors, "/path", problems(*request.path));
        if (frameCount(*request.path) > static_cast<double>(kMostSequenceFrames)) {
            errors.push_back({"/path", "makes too many frames",
                              "at most " + std::to_string(kMostSequenceFrames)});
        }
    } else if (request.frames.empty()) {
        errors.push_back({"/frames", "is empty", "one frame at least; or a path"});
    }
    const SequenceChannels& c = request.channels;
    if (!(c.color || c.depth || c.normal || c.objectId || c.through)) {
        errors.push_back({"/channels", "are all off", "one at least"});
    }
    if (request.common.output.channel != Channel::color) {
        errors.push_back({"/common/output/channel", "does not choose a sequence's files",
                          "channels, beside common"});
    }
}

[[noreturn]] void refuse(std::vector<FieldError> errors) {
    throw RequestError(invalidFields(std::move(errors)));
}

}  // namespace

Sequence sequenceFrom(const json& body) {
    std::vector<FieldError> errors;
    SequenceRequest request;
    FieldReader(errors).object(body, request, "");
    if (errors.empty()) checkWhole(body, request, errors);
    if (!errors.empty()) refuse(std::move(errors));

    Sequence sequence{.channels = request.channels, .first = request.first};
    const json common = body.value("common", json::object());
    for (const json& own : ownFields(body, request)) {
        json frame = common;
        for (const auto& [name, value] : own.items()) frame[name] = value;
        try {
            frameRequestFrom(frame);
        } catch (const RequestError& error) {
            const std::string place =
                request.path ? "/common" : "/frames/" + std::to_string(sequence.frames.size());
            append(errors, place, error.problem().errors);
        }
        // One mistake in what is common is one in every frame; nobody reads ten thousand.
        if (errors.size() > 64) refuse(std::move(errors));
        sequence.frames.push_back(std::move(frame));
    }
    if (sequence.first >= sequence.frames.size()) {
        errors.push_back({"/first", "is behind the last frame",
                          "0 to " + std::to_string(sequence.frames.size() - 1)});
    }
    if (!errors.empty()) refuse(std::move(errors));
    return sequence;
}

json channelsJson(const SequenceChannels& channels) {
    json list = json::object();
    SequenceChannels copy = channels;
    fields(copy, [&](const char* name, bool on, const Flag&, const char*) { list[name] = on; });
    return list;
}

}  // namespace clerestory
