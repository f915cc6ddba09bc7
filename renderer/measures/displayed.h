// What a display shows of linear radiance, without the GPU: so that a reference and a frame that
// were both kept as floats can be compared as people see them.
#pragma once

#include "image/image.h"
#include "plan/request/frame_request.h"

namespace clerestory {

// sRGB-encoded float32, 0..1, 3 channels, by the curves that the toneMap pass runs; any input, also
// NaN. linear: float32, 3 or 4 channels (alpha is ignored). exposureFactor: on the radiance, > 0.
// Throws std::runtime_error for another type.
Image displayed(const Image& linear, ToneMap curve, float exposureFactor = 1.0f);

// The same in 8 bits, rounded to the nearest code.
Image quantised(const Image& displayed);

}  // namespace clerestory
