#include "server/live/ladder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <variant>

namespace clerestory {
namespace {

constexpr std::uint64_t kMinPixels = 160 * 90;
constexpr std::array<double, 3> kScales = {1.0, 0.75, 0.5};
constexpr std::array<double, 5> kDraftScales = {0.5, 0.375, 0.25, 0.1875, 0.125};

std::uint32_t scaled(std::uint32_t edge, double scale) {
    return std::max(1u, static_cast<std::uint32_t>(std::lround(edge * scale)));
}

// Multiplies the fields of a filter that are lengths in pixels.
struct PixelScaler {
    double scale;
    void operator()(const char*, double& value, const Range& range, const char*) const {
        const std::string_view unit = range.unit ? range.unit : "";
        if (unit == "pixels") value *= scale;
    }
    void operator()(const char* name, std::optional<double>& value, const Range& range,
                    const char* words) const {
        if (value) (*this)(name, *value, range, words);
    }
    template <class T, class Kind>
    void operator()(const char* name, T& value, const Required<Kind>& required,
                    const char* words) const {
        (*this)(name, value, required.kind, words);
    }
    template <class T, class Kind>
    void operator()(const char*, T&, const Kind&, const char*) const {}
};

}  // namespace

Ladder ladderOf(const FrameRequest& request) {
    const Accuracy& accuracy = request.accuracy;
    const bool onlyDraft = accuracy == accuracyOf(Preset::draft);
    Ladder ladder{.levels = {Level{}}, .width = request.width, .height = request.height};
    const auto add = [&](double scale, bool draft) {
        const Level level{scale, draft && !onlyDraft};
        const std::uint64_t pixels =
            std::uint64_t{scaled(request.width, scale)} * scaled(request.height, scale);
        if (pixels >= kMinPixels && level.cost() < ladder.levels.back().cost()) {
            ladder.levels.push_back(level);
        }
    };
    for (const double scale : kScales) {
        if (scale < 1.0) add(scale, accuracy.isBudget());
    }
    for (const double scale : kDraftScales) add(scale, true);
    return ladder;
}

FrameRequest atLevel(const FrameRequest& request, const Level& level) {
    FrameRequest frame = request;
    if (level.draft) frame.accuracy = accuracyOf(Preset::draft);
    if (level.scale == 1.0) return frame;
    frame.width = scaled(request.width, level.scale);
    frame.height = scaled(request.height, level.scale);
    if (frame.camera.intrinsics) {
        const double x = static_cast<double>(frame.width) / request.width;
        const double y = static_cast<double>(frame.height) / request.height;
        Intrinsics& lens = *frame.camera.intrinsics;
        // Coordinates of pixel centres are scaled about the corner of the picture.
        const double shift = lens.pixelCenter == PixelCenter::integer ? 0.5 : 0.0;
        lens.fx *= x;
        lens.fy *= y;
        lens.cx = (lens.cx + shift) * x - shift;
        lens.cy = (lens.cy + shift) * y - shift;
    }
    for (FilterRequest& filter : frame.filters) {
        std::visit([&](auto& own) { fields(own, PixelScaler{level.scale}); }, filter);
    }
    return frame;
}

}  // namespace clerestory
