#include "server/api/sequence_request.h"

#include "scene/import/base/field_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

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

// The fields of each frame; `frames`: those of the body.
std::vector<json> ownFields(std::vector<json> frames, const SequenceRequest& request) {
    std::vector<json> list;
    if (request.turntable) return framesOf(*request.turntable, request.common.camera);
    if (!request.path) return frames;
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

// Removes the frames from the body. None if there is no valid list.
std::optional<std::vector<json>> takeFrames(json& body, std::vector<FieldError>& errors) {
    if (!body.is_object() || !body.contains("frames")) return std::nullopt;
    json list = std::move(body["frames"]);
    body.erase("frames");
    const std::string allowed = "a list of at most " + std::to_string(kMaxSequenceFrames);
    if (!list.is_array()) {
        errors.push_back({"/frames", std::string("is ") + list.type_name(), allowed});
        return std::nullopt;
    }
    if (list.size() > kMaxSequenceFrames) {
        errors.push_back({"/frames", "has " + std::to_string(list.size()) + " elements", allowed});
        return std::nullopt;
    }
    return std::move(list.get_ref<json::array_t&>());
}

// Of each frame without the common fields.
void checkFields(const std::vector<json>& frames, std::vector<FieldError>& errors) {
    for (std::size_t i = 0; i < frames.size() && errors.size() < kMaxFieldErrors; ++i) {
        FrameRequest frame;
        FieldReader(errors).object(frames[i], frame, "/frames/" + std::to_string(i));
    }
}

// Sets the field of that name to its value in `from`.
void copyField(FrameRequest& to, FrameRequest& from, std::string_view name) {
    if (name == "scene") {  // two members
        to.scene = from.scene;
        to.parts = from.parts;
        return;
    }
    fields(to, [&](const char* each, auto& target, const auto&, const char*) {
        if (name != each) return;
        fields(from, [&](const char* other, auto& source, const auto&, const char*) {
            using Target = std::decay_t<decltype(target)>;
            constexpr bool isSame = std::is_same_v<Target, std::decay_t<decltype(source)>>;
            if constexpr (isSame && std::is_copy_assignable_v<Target>) {
                if (name == other) target = source;
            }
        });
    });
}

// Checks one frame after the other. The common fields are read once, not for each frame: a few
// kilobytes of them and 100,000 frames took 17 s.
class FrameCheck {
public:
    FrameCheck(const FrameRequest& common, const SequenceChannels& channels)
        : common_(common), frame_(common), classId_(channels.classId) {}

    // Pointers are relative to the frame.
    std::vector<FieldError> operator()(const json& own) {
        if (!own.is_object()) return {{"", std::string("is ") + own.type_name(), "an object"}};
        for (const auto& [name, value] : own.items()) copyField(frame_, defaults_, name);
        std::vector<FieldError> errors;
        FieldReader(errors).object(own, frame_, "");
        if (errors.empty()) errors = problems(frame_);
        if (errors.empty() && classId_) errors = problemsOfClasses();
        for (const auto& [name, value] : own.items()) copyField(frame_, common_, name);
        return errors;
    }

private:
    std::vector<FieldError> problemsOfClasses() {
        Output& output = frame_.output;
        const Channel channel = std::exchange(output.channel, Channel::classId);
        const OutputFormat format = std::exchange(output.format, OutputFormat::npy);
        std::vector<FieldError> errors = problems(frame_);
        output.channel = channel;
        output.format = format;
        return errors;
    }

    FrameRequest common_, defaults_;
    FrameRequest frame_;  // equals common_ between two frames
    const bool classId_;
};

// Rules that involve several fields of the body.
void checkWhole(const std::optional<std::vector<json>>& frames, const SequenceRequest& request,
                std::vector<FieldError>& errors) {
    if (request.path && frames) {
        errors.push_back({"/path", "conflicts with frames", "one of the two"});
    }
    if (request.turntable) {
        if (request.path || frames) {
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
    } else if (!frames || frames->empty()) {
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

// A field of one frame; null: it has its default.
const json* valueOf(const Sequence& sequence, std::size_t frame, const char* name) {
    const json& own = sequence.own[frame];
    if (const auto found = own.find(name); found != own.end()) return &*found;
    const auto common = sequence.common.find(name);
    return common == sequence.common.end() ? nullptr : &*common;
}

// Flow connects frames of one scene and size: only the camera and the time may differ.
void checkFlow(const Sequence& sequence, std::vector<FieldError>& errors) {
    for (std::size_t i = 1; i < sequence.count(); ++i) {
        for (const char* name : {"scene", "clip", "nodes", "width", "height"}) {
            const json* now = valueOf(sequence, i, name);
            const json* before = valueOf(sequence, i - 1, name);
            if (now == before || (now && before && *now == *before)) continue;
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

Sequence sequenceFrom(json body) {
    std::vector<FieldError> errors;
    std::optional<std::vector<json>> frames = takeFrames(body, errors);
    SequenceRequest request;
    FieldReader(errors).object(body, request, "");
    if (!errors.empty() && frames) checkFields(*frames, errors);
    if (errors.empty()) checkWhole(frames, request, errors);
    errors.resize(std::min(errors.size(), kMaxFieldErrors));
    if (!errors.empty()) refuse(std::move(errors));

    Sequence sequence{.common = body.value("common", json::object()),
                      .own = ownFields(std::move(frames).value_or(std::vector<json>()), request),
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
    FrameCheck check(request.common, sequence.channels);
    for (std::size_t i = 0; i < sequence.count(); ++i) {
        const std::string place =
            request.path || request.turntable ? "/common" : "/frames/" + std::to_string(i);
        append(errors, place, check(sequence.own[i]));
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
