// Pixels that have left the GPU. Row by row, the first row is the top of the picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

enum class PixelType { srgb8, float32 };

struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 4;  // interleaved: 1, 3 or 4
    PixelType type = PixelType::srgb8;
    std::vector<std::byte> data;  // width * height * channels of uint8 or float, no padding

    const std::uint8_t* bytes() const { return reinterpret_cast<const std::uint8_t*>(data.data()); }
    std::uint8_t* bytes() { return reinterpret_cast<std::uint8_t*>(data.data()); }
    const float* floats() const { return reinterpret_cast<const float*>(data.data()); }
    float* floats() { return reinterpret_cast<float*>(data.data()); }
};

Image makeImage(std::uint32_t width, std::uint32_t height, std::uint32_t channels, PixelType type);

}  // namespace clerestory
