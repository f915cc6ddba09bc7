// AVIF images -> texels, decoded by libavif 0.11 or later.
#pragma once

#include "scene/material.h"

#include <atomic>
#include <cstdint>
#include <span>

namespace clerestory {

bool isAvif(std::span<const unsigned char> file);

// As decodedImage(). More than 8 bits a channel are reduced to 8; colour profiles are ignored, as
// in all textures. Throws ImportError; sequences, and images that are to be cropped, rotated or
// mirrored, are unsupported.
TextureImage decodedAvif(std::span<const unsigned char> file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft);

}  // namespace clerestory
