// BasisLZ: textures of ETC1S blocks (one base colour and one table of modifiers each) in KTX2
// files, with codebooks of endpoints and selectors. Written from the KTX File Format
// Specification 2.0, "BasisLZ/ETC1S Bitstream Specification".
#pragma once

#include "scene/material.h"

#include <cstdint>
#include <span>

namespace clerestory {

// Decodes level 0 into image.texels, which has the size of the image. globalData: the
// supercompression global data. level: the bytes of level 0. imageCount: of all levels together.
// Throws ImportError if the data is damaged.
void decodeBasisLz(std::span<const unsigned char> globalData, std::span<const unsigned char> level,
                   std::uint32_t imageCount, TextureImage& image);

}  // namespace clerestory
