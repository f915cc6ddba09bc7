// Tone mapping on the CPU, so that a reference and a frame that are both stored as floats can be
// compared as displayed.
#pragma once

#include "image/image.h"
#include "plan/request/frame_request.h"

namespace clerestory {

// sRGB-encoded float32, 0..1, 3 channels, with the curves of the tone mapping pass; defined for any
// input, also NaN. linear: float32, 3 or 4 channels (alpha is ignored). exposureFactor: multiplies
// radiance, > 0. Throws std::runtime_error for other types.
Image displayed(const Image& linear, ToneMap curve, float exposureFactor = 1.0f);

// Rounded to 8 bits.
Image quantised(const Image& displayed);

}  // namespace clerestory
