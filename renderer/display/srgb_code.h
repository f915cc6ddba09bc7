// sRGB codes of 8 bits from linear light and back, by tables.
#pragma once

#include <array>
#include <cstdint>

namespace clerestory::display {

class SrgbCodes {
public:
    SrgbCodes();

    // The code nearest to the light, exactly. light: 0..1.
    std::uint8_t code(float light) const {
        const std::uint8_t low = lowest_[static_cast<std::size_t>(light * kSteps)];
        return static_cast<std::uint8_t>(low + (light >= from_[low + 1]));
    }
    float light(std::uint8_t code) const { return light_[code]; }
    // Before a tone curve compressed it; uncompressed() in edge_filter.frag.
    float uncompressed(std::uint8_t code) const { return uncompressed_[code]; }

private:
    // The steepest part of the curve has 3,295 codes for each unit of light, so that a step holds
    // at most one change of code.
    static constexpr float kSteps = 8191.0f;

    std::array<std::uint8_t, 8192> lowest_{};  // code at the beginning of each step
    std::array<float, 257> from_{};            // least light of each code; of 256: none
    std::array<float, 256> light_{}, uncompressed_{};
};

const SrgbCodes& srgbCodes();

// Display light of uncompressed light; the inverse of uncompressed(). light: at least 0.
float compressed(float light);

}  // namespace clerestory::display
