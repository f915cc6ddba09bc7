// Images in CPU memory, row by row with the top row first; and their files: JPEG, WebP, PNG, EXR
// and NPY.
//
// Encoding, and decoding of what tests and the importer need, are thread-safe: there is no shared
// state. These functions throw std::runtime_error with the cause.
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
// The same in the memory of `image`; the values of the pixels are unspecified.
void reshape(Image& image, std::uint32_t width, std::uint32_t height, std::uint32_t channels,
             PixelType type);

// Checks for encoders: throws std::runtime_error, naming the format, unless the image has pixels,
// this type, one of these channel counts, as much data as its size requires, and no edge above
// maxEdge.
void requireImage(const Image& image, const std::string& format, PixelType type,
                  std::initializer_list<std::uint32_t> channels, std::uint32_t maxEdge);

// Check for decoders: throws std::runtime_error if the size that a file claims exceeds
// kMaxDecodedPixels.
inline constexpr std::uint64_t kMaxDecodedPixels = 1u << 26;
void requireDecodable(const std::string& format, std::uint64_t width, std::uint64_t height);

using Bytes = std::string;  // file content

// srgb8 images of 3 or 4 channels; alpha is ignored. quality 1..100.
Bytes encodeJpeg(const Image& image, int quality, bool subsample420);
// The same; lossy, at most 16383 pixels along an edge. Alpha is straight, and kept without loss.
Bytes encodeWebp(const Image& image, int quality);
Bytes encodePng(const Image& image);  // srgb8, 1, 3 or 4 channels
Bytes encodeNpy(const Image& image);  // float32, shape H x W x C (NPY version 1.0)
Bytes encodeExr(const Image& image);  // float32; channels named Y, or R G B (A)

Image decodeJpeg(std::string_view bytes);  // 3 channels
Image decodePng(std::string_view bytes);   // 4 channels
Image decodeNpy(std::string_view bytes);   // only files written by encodeNpy

}  // namespace clerestory
