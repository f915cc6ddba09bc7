// Pictures with alpha.
#pragma once

#include "image/image.h"

#include <array>
#include <cstddef>

namespace clerestory::test {

// A transparent picture before a colour, in linear light.
inline Image over(const Image& premultiplied, const std::array<double, 3>& background) {
    Image image = makeImage(premultiplied.width, premultiplied.height, 3, PixelType::float32);
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i) {
        const float* in = premultiplied.floats() + 4 * i;
        for (std::size_t c = 0; c < 3; ++c) {
            image.floats()[3 * i + c] = in[c] + (1.0f - in[3]) * static_cast<float>(background[c]);
        }
    }
    return image;
}

}  // namespace clerestory::test
