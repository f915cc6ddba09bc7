// Where a picture is wrong, as colours.
#pragma once

#include "image/image.h"

#include <glm/glm.hpp>

namespace clerestory {

// Black through violet and orange to pale yellow, lighter all the way. t: 0..1, clamped; sRGB
// codes.
glm::u8vec3 falseColour(double t);

// |x - r| / (r + e) of each pixel, means over its channels, as falseColour(that / most); e is 1 %
// of the reference's mean. Pixels that are not finite in either are cyan. float32 pictures of one
// size with 3 or 4 channels; most > 0. srgb8, 3 channels. Throws std::runtime_error.
Image errorPicture(const Image& actual, const Image& reference, double most = 1.0);

}  // namespace clerestory
