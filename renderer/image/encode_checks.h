// What every encoder asks of the image it is given, and every decoder of the size a file claims.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <initializer_list>
#include <string>

namespace clerestory {

// Throws std::runtime_error, naming the format, unless the image has pixels, the type, one of the
// channel counts, as many bytes as its size says, and no edge above maxEdge.
void requireImage(const Image& image, const std::string& format, PixelType type,
                  std::initializer_list<std::uint32_t> channels, std::uint32_t maxEdge);

// Throws unless a picture of this size may be decoded: a few bytes of file can claim gigabytes.
inline constexpr std::uint64_t kMaxDecodedPixels = 1u << 26;
void requireDecodable(const std::string& format, std::uint64_t width, std::uint64_t height);

}  // namespace clerestory
