// KTX2 textures of KHR_texture_basisu -> texels: UASTC blocks, with or without Zstandard, and
// ETC1S with BasisLZ.
//
// Does not: read cube maps and uncompressed formats (environment_reader.h), levels other than 0.
#pragma once

#include "scene/material.h"

#include <atomic>
#include <cstdint>
#include <span>

namespace clerestory {

bool isKtx2(std::span<const unsigned char> file);

// As decodedImage(). Throws ImportError; textures with layers, faces, depth or other formats are
// unsupported.
TextureImage decodedKtx2(std::span<const unsigned char> file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft);

}  // namespace clerestory
