// Pixels in CPU memory, row by row; the first row is the top of the image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
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

// Checks for encoders: throws std::runtime_error, naming the format, unless the image has pixels,
// this type, one of these channel counts, as much data as its size requires, and no edge above
// maxEdge.
void requireImage(const Image& image, const std::string& format, PixelType type,
                  std::initializer_list<std::uint32_t> channels, std::uint32_t maxEdge);

// Check for decoders: throws std::runtime_error if the size that a file claims exceeds
// kMaxDecodedPixels.
inline constexpr std::uint64_t kMaxDecodedPixels = 1u << 26;
void requireDecodable(const std::string& format, std::uint64_t width, std::uint64_t height);

}  // namespace clerestory
