#include "display/srgb_code.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory::display {
namespace {

// IEC 61966-2-1. code: 0..1.
double linearFromSrgb(double code) {
    return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

// As in edge_filter.frag.
constexpr float kRollOff = 0.76f, kRoom = 0.24f, kKept = 127.0f / 128.0f;

}  // namespace

float compressed(float light) {
    const float above = std::max(light - kRollOff, 0.0f);
    return std::min(std::min(light, kRollOff) + kRoom / kKept * above / (above + kRoom), 1.0f);
}

SrgbCodes::SrgbCodes() {
    for (std::size_t code = 0; code < 256; ++code) {
        const auto value = static_cast<double>(code);
        light_[code] = static_cast<float>(linearFromSrgb(value / 255.0));
        const float above = std::max(light_[code] - kRollOff, 0.0f);
        uncompressed_[code] =
            std::min(light_[code], kRollOff) + kRoom * kRoom / (kRoom - kKept * above) - kRoom;
        from_[code] = static_cast<float>(code > 0 ? linearFromSrgb((value - 0.5) / 255.0) : 0.0);
    }
    from_[256] = std::numeric_limits<float>::infinity();
    std::uint8_t code = 0;
    for (std::size_t step = 0; step < lowest_.size(); ++step) {
        // Least light whose product with kSteps is rounded to the step or above.
        const float begin = std::nextafter(static_cast<float>(step) / kSteps, 0.0f);
        while (begin >= from_[code + 1]) ++code;
        lowest_[step] = code;
    }
}

const SrgbCodes& srgbCodes() {
    static const SrgbCodes codes;
    return codes;
}

}  // namespace clerestory::display
