// A file: a line with the checksum of the rest, a line of figures, the key.
#include "server/jobs/curve_store.h"

#include "scene/hash.h"
#include "scene/import/cache/scene_cache.h"
#include "server/base/log.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>

namespace clerestory {
namespace {

constexpr const char* kExtension = ".curve";
constexpr std::uint64_t kMaxCurveBytes = 1 << 20;  // of one; a few kilobytes as a rule
constexpr std::uint64_t kMaxBytesOfAll = 64ull << 20;

// Its settings are those of ladder(), which another program (and so another key) may have changed.
std::string figuresOf(const Curve& curve) {
    char number[40];
    std::string text;
    const auto add = [&](double value) {
        std::snprintf(number, sizeof number, "%.17g ", value);
        text += number;
    };
    add(curve.relMseNoise);
    for (const CurvePoint& p : curve.points) {
        add(p.milliseconds);
        add(p.relMse);
    }
    return text;
}

std::optional<Curve> curveFrom(const std::string& figures) {
    std::istringstream text(figures);
    Curve curve;
    bool sound = static_cast<bool>(text >> curve.relMseNoise);
    const auto good = [](double value) { return std::isfinite(value) && value >= 0.0; };
    for (const Accuracy& accuracy : ladder()) {
        CurvePoint p{.accuracy = accuracy};
        sound =
            sound && text >> p.milliseconds >> p.relMse && good(p.milliseconds) && good(p.relMse);
        curve.points.push_back(p);
    }
    if (!sound || !(text >> std::ws).eof()) return std::nullopt;
    return curve;
}

}  // namespace

std::filesystem::path CurveStore::fileOf(const std::string& key) const {
    return folder_ / (hashWordOf(key) + kExtension);
}

std::optional<Curve> CurveStore::find(const std::string& key) const {
    const auto content = readCacheFile(fileOf(key), kMaxCurveBytes);
    if (!content) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(content->bytes.get()), content->size);
    const std::size_t first = text.find('\n');
    const std::size_t second = first == text.npos ? first : text.find('\n', first + 1);
    if (second == text.npos || text.substr(0, first) != hashWordOf(text.substr(first + 1)) ||
        text.substr(second + 1) != key) {
        return std::nullopt;
    }
    return curveFrom(std::string(text.substr(first + 1, second - first - 1)));
}

void CurveStore::keep(const std::string& key, const Curve& curve) const {
    const std::string rest = figuresOf(curve) + '\n' + key;
    const std::string text = hashWordOf(rest) + '\n' + rest;
    if (text.size() > kMaxCurveBytes) return;
    if (writeCacheFile(fileOf(key), {std::as_bytes(std::span(text))})) {
        trimCacheFolder(folder_, kExtension, kMaxBytesOfAll);
    } else {
        logDebug({"a curve cannot be kept: ", std::strerror(errno)});
    }
}

}  // namespace clerestory
