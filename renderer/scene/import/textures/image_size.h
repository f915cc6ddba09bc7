// The size checks that all image decoders share. They come before the first allocation, since a
// small file can declare a huge image.
#pragma once

#include "scene/material.h"

#include <atomic>
#include <cstdint>

namespace clerestory {

// Throws ImportError for an image without pixels (malformed) or with more than maxPixels (limit).
void checkImageSize(std::int64_t width, std::int64_t height, std::uint64_t maxPixels);

// Checks the size, subtracts the pixels from the scene's remaining allowance, and returns level 0
// with undefined texels. Throws ImportError.
TextureImage allottedImage(std::int64_t width, std::int64_t height, std::uint64_t maxPixels,
                           std::atomic<std::uint64_t>& pixelsLeft);

}  // namespace clerestory
