// The transfer function of sRGB (IEC 61966-2-1), channel by channel.
#pragma once

#include <cmath>

namespace clerestory {

// Both in [0, 1]; beyond it the same curves continue.
inline float linearFromSrgb(float code) {
    return code <= 0.04045f ? code / 12.92f : std::pow((code + 0.055f) / 1.055f, 2.4f);
}
inline float srgbFromLinear(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

}  // namespace clerestory
