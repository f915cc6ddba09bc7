#include "server/live/film_request.h"

#include "server/api/encode_answer.h"
#include "server/base/problem.h"

namespace clerestory {
namespace {

using nlohmann::json;

void checkChannels(const SequenceChannels& channels, std::vector<FieldError>& errors) {
    SequenceChannels copy = channels;
    fields(copy, [&](const char* name, bool on, const Flag&, const char*) {
        const bool isColor = name == std::string_view("color");
        if (on == isColor) return;
        errors.push_back({std::string("/channels/") + name,
                          isColor ? "is off, but a film shows this channel" : "cannot be in a film",
                          isColor ? "true" : "false; only the channel color"});
    });
}

// The size and the output are those of all frames.
void checkFrames(const Sequence& sequence, std::vector<FieldError>& errors) {
    for (std::size_t i = 0; i < sequence.own.size(); ++i) {
        for (const char* name : {"width", "height", "output"}) {
            const auto own = sequence.own[i].find(name);
            if (own == sequence.own[i].end()) continue;
            const auto common = sequence.common.find(name);
            if (common != sequence.common.end() && *own == *common) continue;
            errors.push_back({"/frames/" + std::to_string(i) + "/" + name,
                              "differs from that in common",
                              "one value for a whole film, in common"});
        }
        if (errors.size() > kMaxFieldErrors) return;
    }
}

void checkMp4(const FilmSettings& film, std::vector<FieldError>& errors) {
    for (const auto& [name, edge] : {std::pair{"width", film.width}, {"height", film.height}}) {
        if (edge % 2 == 0) continue;
        errors.push_back({std::string("/common/") + name,
                          "is odd, and H.264 halves the resolution of colour", "an even number"});
    }
    if (std::uint64_t(film.width) * film.height > kMaxMp4Pixels) {
        errors.push_back({"/common/width", "is too large for this height in MP4",
                          "at most " + std::to_string(kMaxMp4Pixels) +
                              " pixels, as 4096 x 2304 (H.264, level 5.2)"});
    }
    const std::string missing = mp4Missing();
    if (!missing.empty()) {
        errors.push_back({"/Accept", "is video/mp4, which this server cannot encode: " + missing,
                          "image/webp, multipart/mixed, application/x-tar"});
    }
}

void checkWebp(const FilmSettings& film, const Sequence& sequence,
               std::vector<FieldError>& errors) {
    const std::uint64_t pixels = std::uint64_t(film.width) * film.height;
    const std::uint64_t most = kMaxWebpFilmPixels / pixels;
    if (sequence.end - sequence.first <= most) return;
    errors.push_back({"/count", "is too large for an animated WebP of this size",
                      "at most " + std::to_string(most) + " frames, or video/mp4"});
}

}  // namespace

const char* mediaType(FilmFormat format) {
    return format == FilmFormat::mp4 ? "video/mp4" : "image/webp";
}

std::optional<FilmFormat> filmFormatIn(const std::string& accept) {
    for (const FilmFormat format : {FilmFormat::mp4, FilmFormat::webp}) {
        if (accept.find(mediaType(format)) != std::string::npos) return format;
    }
    return std::nullopt;
}

std::optional<FilmFormat> filmFormatOf(std::string_view file) {
    if (file.ends_with(".mp4")) return FilmFormat::mp4;
    if (file.ends_with(".webp")) return FilmFormat::webp;
    return std::nullopt;
}

FilmSettings makeFilmSequence(Sequence& sequence, FilmFormat format) {
    std::vector<FieldError> errors;
    checkChannels(sequence.channels, errors);
    if (!sequence.frameRate) {
        errors.push_back({"/frameRate", "is missing; a film of frames requires it",
                          "frames per second, 0.001 to 1000"});
    }
    checkFrames(sequence, errors);
    const FrameRequest first = sequence.request(sequence.first);
    const FilmSettings film{.format = format,
                            .width = first.width,
                            .height = first.height,
                            .frameRate = sequence.frameRate.value_or(30.0),
                            .quality = first.output.quality};
    if (format == FilmFormat::mp4) {
        checkMp4(film, errors);
    } else {
        checkWebp(film, sequence, errors);
    }
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    for (json& own : sequence.own) own.erase("output");
    sequence.common["output"]["format"] = format == FilmFormat::mp4 ? "png" : "webp";
    sequence.plans = false;
    return film;
}

}  // namespace clerestory
