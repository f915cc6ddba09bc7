// sRGB pictures as Y'CbCr of ITU-R BT.709-6 in 8 bits and limited range (luma 16 to 235, colour
// differences 16 to 240), 4:2:0. The curve of the codes stays that of sRGB.
#pragma once

#include "image/image.h"

#include <array>

namespace clerestory {

struct ImagePlane {
    std::uint8_t* bytes = nullptr;
    int stride = 0;  // bytes from row to row
};

// srgb8 with 4 channels and even edges; alpha is ignored. Planes: Y' of the size of the image, Cb
// and Cr of half of it. A colour difference lies at the left pixel of its two columns and between
// its two rows, where decoders of H.264 expect it, and is the mean with the weights 1, 2, 1 across.
void toBt709(const Image& image, const std::array<ImagePlane, 3>& planes);

}  // namespace clerestory
