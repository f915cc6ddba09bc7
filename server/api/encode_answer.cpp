#include "server/api/encode_answer.h"

#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>

namespace clerestory {
namespace {

std::string trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    std::string word(text.substr(begin, text.find_last_not_of(" \t") - begin + 1));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return word;
}

// Whether a media range of the header matches the type with a weight above zero (RFC 9110
// 12.5.1).
bool accepts(const std::string& accept, std::string_view type) {
    const std::string family = std::string(type.substr(0, type.find('/'))) + "/*";
    for (std::size_t begin = 0; begin < accept.size();) {
        const std::size_t end = std::min(accept.find(',', begin), accept.size());
        const std::string item = accept.substr(begin, end - begin);
        begin = end + 1;
        const std::size_t semicolon = std::min(item.find(';'), item.size());
        const std::string range = trimmed(item.substr(0, semicolon));
        if (range != type && range != family && range != "*/*") continue;
        const std::string weight = trimmed(item.substr(std::min(semicolon + 1, item.size())));
        if (weight.rfind("q=0", 0) == 0 && weight.find_first_of("123456789") == std::string::npos) {
            continue;
        }
        return true;
    }
    return false;
}

}  // namespace

std::string_view mediaType(OutputFormat format) {
    switch (format) {
        case OutputFormat::jpeg:
            return "image/jpeg";
        case OutputFormat::png:
            return "image/png";
        case OutputFormat::npy:
            return "application/x-npy";
        case OutputFormat::exr:
            return "image/x-exr";
        case OutputFormat::webp:
            return "image/webp";
        case OutputFormat::json:
            return "application/json";
    }
    return "";
}

OutputFormat formatFor(const std::string& accept) {
    for (const OutputFormat format : {OutputFormat::jpeg, OutputFormat::png, OutputFormat::npy,
                                      OutputFormat::exr, OutputFormat::webp}) {
        if (accepts(accept, mediaType(format))) return format;
    }
    return OutputFormat::jpeg;
}

Bytes encoded(const Image& image, const Output& output) {
    switch (output.format) {
        case OutputFormat::jpeg:
            return encodeJpeg(image, static_cast<int>(output.quality),
                              output.subsampling == Subsampling::s420);
        case OutputFormat::png:
            return encodePng(image);
        case OutputFormat::npy:
            return encodeNpy(image);
        case OutputFormat::exr:
            return encodeExr(image);
        case OutputFormat::webp:
            return encodeWebp(image, static_cast<int>(output.quality));
        case OutputFormat::json:
            break;
    }
    return {};
}

Bytes encoded(const Frame& frame, const Output& output) {
    return output.format == OutputFormat::json ? jsonText(instancesJson(frame, output.classes), 1)
                                               : encoded(frame.image, output);
}

void addPlan(EncodedFrame& encoded, const Frame& frame) {
    encoded.camera = cameraOf(frame.plan);
    encoded.passMilliseconds = 0.0;
    for (const PassTime& time : frame.passTimes) encoded.passMilliseconds += time.milliseconds;
    encoded.plan = jsonText(planJson(frame.plan, frame.passTimes), 1);
}

}  // namespace clerestory
