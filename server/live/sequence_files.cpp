#include "server/live/sequence_files.h"

#include "server/api/encode_answer.h"

namespace clerestory {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* kJsonType = "application/json";

// Channels of numbers are float32, which npy and exr store without loss.
FrameRequest channelRequest(const FrameRequest& frame, Channel channel) {
    FrameRequest request = frame;
    if (channel == Channel::color) return request;
    request.output.channel = channel;
    OutputFormat& format = request.output.format;
    if (channel == Channel::instances) {
        format = OutputFormat::json;
    } else if (format != OutputFormat::exr) {
        format = OutputFormat::npy;
    }
    return request;
}

FrameRequest flowRequest(const FrameRequest& frame, const FrameRequest& other) {
    FrameRequest request = channelRequest(frame, Channel::flow);
    request.output.flow = FlowRequest{other.time, other.camera};
    return request;
}

std::string extensionOf(const std::string& type) {
    for (const auto& [format, extension] :
         {std::pair{OutputFormat::jpeg, ".jpg"}, std::pair{OutputFormat::png, ".png"},
          std::pair{OutputFormat::npy, ".npy"}, std::pair{OutputFormat::exr, ".exr"},
          std::pair{OutputFormat::webp, ".webp"}, std::pair{OutputFormat::json, ".json"}}) {
        if (type == mediaType(format)) return extension;
    }
    return "";
}

ordered_json recordJson(const FrameRecord& record) {
    ordered_json json = {{"index", record.index},
                         {"time", record.time},
                         {"camera", nullptr},
                         {"files", ordered_json::object()}};
    if (record.camera) json["camera"] = cameraJson(*record.camera);
    for (const FrameRecord::ChannelFile& channel : record.channels) {
        json["files"][channel.channel] = channel.file;
        if (channel.milliseconds) json["milliseconds"][channel.channel] = *channel.milliseconds;
    }
    return json;
}

// Indents every line but the first by `depth`. JSON has no line breaks within strings.
std::string indented(const std::string& json, std::size_t depth) {
    std::string text;
    for (const char c : json) {
        text += c;
        if (c == '\n') text.append(depth, ' ');
    }
    return text;
}

// The record with the member "plans", which holds the finished texts by name of the channel.
std::string frameJson(const FrameRecord& record,
                      const std::vector<std::pair<std::string, std::string>>& plans) {
    std::string text = jsonText(recordJson(record), 1);
    text.resize(text.size() - 2);  // without the "\n}" at the end
    text += ",\n \"plans\": {";
    const char* separator = "";
    for (const auto& [channel, plan] : plans) {
        text += separator + ("\n  \"" + channel + "\": ") + indented(plan, 2);
        separator = ",";
    }
    return text + "\n }\n}";
}

}  // namespace

std::string frameStem(std::size_t index) {
    const std::string digits = std::to_string(index);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

FrameFiles filesOf(const Sequence& sequence, std::size_t index, const FrameMaker& make) {
    const FrameRequest frame = sequence.request(index);
    const std::string stem = frameStem(index);
    FrameFiles made{.record = {.index = index, .time = frame.time}};
    std::vector<std::pair<std::string, std::string>> plans;
    const auto addFile = [&](const FrameRequest& request, const std::string& name) {
        EncodedFrame encoded = make(request);
        const bool isColor = request.output.channel == Channel::color;
        const std::string middle = isColor ? "" : "." + name;
        const std::string file = stem + middle + extensionOf(encoded.type);
        made.record.camera = encoded.camera;
        FrameRecord::ChannelFile& record = made.record.channels.emplace_back(name, file);
        if (sequence.plans) {
            record.milliseconds = encoded.passMilliseconds;
            plans.emplace_back(name, std::move(encoded.plan));
        }
        made.files.push_back({file, std::move(encoded.type), std::move(encoded.bytes)});
    };
    const auto addLayers = [&](FrameRequest request, const char* name) {
        request.output.layer = OutputLayer::direct;
        addFile(request, name);
        if (!hasLayers(request.output.channel)) return;
        for (const auto& [wanted, layer, prefix] :
             {std::tuple{sequence.layers.reflected, OutputLayer::reflected, "reflected."},
              std::tuple{sequence.layers.refracted, OutputLayer::refracted, "refracted."}}) {
            request.output.layer = layer;
            if (wanted) addFile(request, std::string(prefix) + name);
        }
    };
    const auto add = [&](bool on, Channel channel, const char* name) {
        if (on) addLayers(channelRequest(frame, channel), name);
    };
    const SequenceChannels& on = sequence.channels;
    add(on.color, Channel::color, "color");
    add(on.depth, Channel::depth, "depth");
    add(on.normal, Channel::normal, "normal");
    add(on.position, Channel::position, "position");
    add(on.albedo, Channel::albedo, "albedo");
    add(on.objectId, Channel::objectId, "objectId");
    add(on.materialId, Channel::materialId, "materialId");
    add(on.classId, Channel::classId, "classId");
    add(on.through, Channel::through, "through");
    if (on.flow && index + 1 < sequence.count()) {
        addLayers(flowRequest(frame, sequence.request(index + 1)), "flow");
    }
    if (on.flowBack && index > 0) {
        addLayers(flowRequest(frame, sequence.request(index - 1)), "flowBack");
    }
    add(on.instances, Channel::instances, "instances");
    made.files.push_back(
        {stem + ".json", kJsonType,
         sequence.plans ? frameJson(made.record, plans) : jsonText(recordJson(made.record), 1)});
    return made;
}

void Manifest::add(const FrameRecord& record) {
    frames_.push_back(recordJson(record));
}

void Manifest::addFromFile(const std::string& text) {
    ordered_json frame = ordered_json::parse(text);
    frame.erase("plans");
    frames_.push_back(std::move(frame));
}

void Manifest::addFailure(std::size_t index, const json& problem) {
    frames_.push_back({{"index", index}, {"failure", problem}});
    ++failures_;
}

SequenceFile Manifest::file() const {
    return {"manifest.json", kJsonType,
            jsonText({{"frames", frames_}, {"failures", failures_}}, 1)};
}

}  // namespace clerestory
