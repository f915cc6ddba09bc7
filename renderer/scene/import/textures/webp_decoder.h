// WebP images -> texels, decoded by libwebp.
#pragma once

#include "scene/material.h"

#include <atomic>
#include <cstdint>
#include <span>

namespace clerestory {

bool isWebp(std::span<const unsigned char> file);

// As decodedImage(). Throws ImportError; animations are unsupported.
TextureImage decodedWebp(std::span<const unsigned char> file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft);

}  // namespace clerestory
