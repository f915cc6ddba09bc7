#include "server/live/sequence_files.h"

#include "server/api/encode_answer.h"

namespace clerestory {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* kJsonType = "application/json";

std::string textOf(const ordered_json& value, int indent) {
    return value.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

// Every channel but colour is float32, which npy and exr store without loss.
FrameRequest channelRequest(const FrameRequest& frame, Channel channel) {
    FrameRequest request = frame;
    if (channel == Channel::color) return request;
    request.output.channel = channel;
    if (request.output.format != OutputFormat::exr) request.output.format = OutputFormat::npy;
    return request;
}

std::string extensionOf(const std::string& type) {
    for (const auto& [format, extension] :
         {std::pair{OutputFormat::jpeg, ".jpg"}, std::pair{OutputFormat::png, ".png"},
          std::pair{OutputFormat::npy, ".npy"}, std::pair{OutputFormat::exr, ".exr"}}) {
        if (type == mediaType(format)) return extension;
    }
    return "";
}

double millisecondsIn(const ordered_json& plan) {
    double sum = 0.0;
    for (const ordered_json& pass : plan.at("passes")) sum += pass.value("milliseconds", 0.0);
    return sum;
}

}  // namespace

std::string frameStem(std::size_t index) {
    const std::string digits = std::to_string(index);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

std::vector<SequenceFile> filesOf(const Sequence& sequence, std::size_t index,
                                  const FrameMaker& make) {
    const FrameRequest frame = sequence.request(index);
    const std::string stem = frameStem(index);
    std::vector<SequenceFile> files;
    ordered_json about = {{"index", index},
                          {"time", frame.time},
                          {"camera", nullptr},
                          {"files", ordered_json::object()},
                          {"milliseconds", ordered_json::object()}};
    ordered_json plans = ordered_json::object();
    const auto add = [&](bool on, Channel channel, const char* name) {
        if (!on) return;
        MadeFrame made = make(channelRequest(frame, channel));
        const std::string middle = channel == Channel::color ? "" : "." + std::string(name);
        const std::string file = stem + middle + extensionOf(made.type);
        about["camera"] = made.plan.value("camera", ordered_json());
        about["files"][name] = file;
        about["milliseconds"][name] = millisecondsIn(made.plan);
        plans[name] = std::move(made.plan);
        files.push_back({file, std::move(made.type), std::move(made.bytes)});
    };
    const SequenceChannels& on = sequence.channels;
    add(on.color, Channel::color, "color");
    add(on.depth, Channel::depth, "depth");
    add(on.normal, Channel::normal, "normal");
    add(on.objectId, Channel::objectId, "objectId");
    add(on.through, Channel::through, "through");
    about["plans"] = std::move(plans);
    files.push_back({stem + ".json", kJsonType, textOf(about, 1)});
    return files;
}

void Manifest::add(const SequenceFile& frameJson) {
    ordered_json about = ordered_json::parse(frameJson.bytes);
    about.erase("plans");
    frames_.push_back(std::move(about));
}

void Manifest::addFailure(std::size_t index, const json& problem) {
    frames_.push_back({{"index", index}, {"failure", problem}});
    ++failures_;
}

SequenceFile Manifest::file() const {
    return {"manifest.json", kJsonType, textOf({{"frames", frames_}, {"failures", failures_}}, 1)};
}

}  // namespace clerestory
