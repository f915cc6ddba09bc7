#include "server/api/sequence_request.h"

#include "scene/import/base/field_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory {
namespace {

using nlohmann::json;

std::size_t frameCount(const Turntable& turntable) {
    return std::max<std::size_t>(
        static_cast<std::size_t>(std::llround(turntable.seconds * turntable.frameRate)), 1);
}

std::vector<json> framesOf(const Turntable& turntable, const CameraRequest& from) {
    CameraRequest camera = from;
    if (!camera.fit) camera.fit.emplace();
    camera.fit->allAround = true;
    const std::size_t count = frameCount(turntable);
    std::vector<json> list;
    for (std::size_t i = 0; i < count; ++i) {
        // Whole turns are left out: equal poses are equal numbers.
        const double turn = turntable.turns * static_cast<double>(i) / static_cast<double>(count);
        camera.fit->azimuth = (from.fit ? from.fit->azimuth : FitRequest{}.azimuth) +
                              2.0 * std::numbers::pi * (turn - std::trunc(turn));
        list.push_back({{"camera", json(cameraJson(camera))}});
    }
    return list;
}

// The fields of each frame.
std::vector<json> ownFields(const json& body, const SequenceRequest& request) {
    std::vector<json> list;
    if (request.turntable) return framesOf(*request.turntable, request.common.camera);
    if (!request.path) return body.value("frames", list);
    for (const PathFrame& frame : framesOf(*request.path)) {
        list.push_back({{"time", frame.time}, {"camera", json(cameraJson(frame.camera))}});
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

// Rules that involve several fields of the body.
void checkWhole(const json& body, const SequenceRequest& request, std::vector<FieldError>& errors) {
    if (request.path && body.contains("frames")) {
        errors.push_back({"/path", "conflicts with frames", "one of the two"});
    }
    if (request.turntable) {
        if (request.path || body.contains("frames")) {
            errors.push_back({"/turntable", "conflicts with path or frames", "one of the three"});
        }
        if (frameCount(*request.turntable) > kMaxSequenceFrames) {
            errors.push_back({"/turntable", "has too many frames",
                              "at most " + std::to_string(kMaxSequenceFrames)});
        }
        const CameraRequest& c = request.common.camera;
        if (c.position || c.target || c.up || c.orientation || c.cameraToWorld || c.name) {
            errors.push_back({"/common/camera", "has a pose, which conflicts with turntable",
                              "fit with a lens, or nothing"});
        }
    } else if (request.path) {
        append(errors, "/path", problems(*request.path));
        if (frameCount(*request.path) > static_cast<double>(kMaxSequenceFrames)) {
            errors.push_back(
                {"/path", "has too many frames", "at most " + std::to_string(kMaxSequenceFrames)});
        }
    } else if (request.frames.empty()) {
        errors.push_back({"/frames", "is empty", "at least one frame, or a path, or a turntable"});
    }
    if (request.frameRate && (request.path || request.turntable)) {
        errors.push_back(
            {"/frameRate", "conflicts with the frameRate of path or turntable", "one of the two"});
    }
    bool any = false;
    SequenceChannels channels = request.channels;
    fields(channels, [&](const char*, bool on, const Flag&, const char*) { any = any || on; });
    if (!any) {
        errors.push_back({"/channels", "are all off", "at least one channel"});
    }
    if (request.common.output.layer != OutputLayer::direct) {
        errors.push_back({"/common/output/layer", "does not select the files of a sequence",
                          "the field layers, next to common"});
    }
    if (request.common.output.channel != Channel::color) {
        errors.push_back({"/common/output/channel", "does not select the files of a sequence",
                          "the field channels, next to common"});
    }
}

// Flow connects frames of one scene and size: only the camera and the time may differ.
void checkFlow(const Sequence& sequence, std::vector<FieldError>& errors) {
    for (std::size_t i = 1; i < sequence.count(); ++i) {
        for (const char* name : {"scene", "clip", "nodes", "width", "height"}) {
            const auto valueIn = [&](std::size_t frame) {
                const json& own = sequence.own[frame];
                return own.contains(name) ? own[name] : sequence.common.value(name, json());
            };
            if (valueIn(i) == valueIn(i - 1)) continue;
            errors.push_back({"/frames/" + std::to_string(i) + "/" + name,
                              "differs from that of the previous frame, which flow does not allow",
                              "one value for all frames, in common"});
        }
        if (errors.size() > kMaxFieldErrors) return;
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
    errors.resize(std::min(errors.size(), kMaxFieldErrors));
    if (!errors.empty()) refuse(std::move(errors));

    Sequence sequence{.common = body.value("common", json::object()),
                      .own = ownFields(body, request),
                      .channels = request.channels,
                      .layers = request.layers,
                      .first = request.first,
                      .plans = request.plans,
                      .frameRate = request.frameRate};
    if (request.path) sequence.frameRate = request.path->frameRate;
    if (request.turntable) sequence.frameRate = request.turntable->frameRate;
    sequence.end = request.count ? std::min(sequence.first + *request.count, sequence.count())
                                 : sequence.count();
    if (sequence.common.dump().size() > kMaxSequenceText / sequence.count()) {
        refuse({{"/common", "is too long for this number of frames",
                 std::to_string(kMaxSequenceText / sequence.count()) + " bytes"}});
    }
    if (sequence.channels.flow || sequence.channels.flowBack) checkFlow(sequence, errors);
    if (!errors.empty()) refuse(std::move(errors));
    for (std::size_t i = 0; i < sequence.count(); ++i) {
        try {
            FrameRequest frame = sequence.request(i);
            if (!sequence.channels.classId) continue;
            frame.output.channel = Channel::classId;
            frame.output.format = OutputFormat::npy;
            if (auto wrong = problems(frame); !wrong.empty()) {
                throw RequestError(invalidFields(std::move(wrong)));
            }
        } catch (const RequestError& error) {
            const std::string place =
                request.path || request.turntable ? "/common" : "/frames/" + std::to_string(i);
            append(errors, place, error.problem().errors);
        }
        // An error in the common fields is an error of every frame: report it once.
        if (errors.size() > kMaxFieldErrors) refuse(std::move(errors));
    }
    if (sequence.first >= sequence.count()) {
        errors.push_back(
            {"/first", "is after the last frame", "0 to " + std::to_string(sequence.count() - 1)});
    }
    if (!errors.empty()) refuse(std::move(errors));
    return sequence;
}

FrameRequest Sequence::request(std::size_t index) const {
    json frame = common;
    for (const auto& [name, value] : own.at(index).items()) frame[name] = value;
    return frameRequestFrom(frame);
}

namespace {

template <class Switches>
json switchesOf(Switches switches) {
    json list = json::object();
    fields(switches, [&](const char* name, bool on, const Flag&, const char*) { list[name] = on; });
    return list;
}

}  // namespace

json switchesJson(const SequenceChannels& channels) {
    return switchesOf(channels);
}
json switchesJson(const SequenceLayers& layers) {
    return switchesOf(layers);
}

}  // namespace clerestory
