// Where a picture has contrast.
//
//     const std::vector<std::uint32_t> pixels =
//         display::contrastingPixels(picture.image, {.leastContrast = 0.1, .share = 0.25});
#pragma once

#include "image/image.h"

#include <cstdint>
#include <vector>

namespace clerestory::display {

struct ContrastLimits {
    double leastContrast = 0.1;  // 0..1; 0: every pixel
    double share = 1.0;          // of the pixels of the picture, 0..1: at most so many are chosen
};

// The pixels whose contrast is at least the least one, in ascending order, row by row from the top.
// Contrast is the largest difference within a square of 3 x 3 pixels, of one of the four channels
// of an srgb8 picture: 1 is 255 codes. What is near a very strong contrast counts as a moderate
// one: what is bright and smaller than a pixel appears in some pixels and is missing in others. If
// there are too many, those with the most contrast are chosen, and of equal ones an even selection.
std::vector<std::uint32_t> contrastingPixels(const Image& picture, const ContrastLimits& limits);

}  // namespace clerestory::display
