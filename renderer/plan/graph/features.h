// The feature bits of shaders/include/features.glsl as C++ constants; see Draw::features.
#pragma once

#include "plan/graph/draw.h"

namespace clerestory {
using uint = Features;  // so that the complement of a bit has all other bits
#include "shaders/include/features.glsl"

// LAYER_ bits are the upper half of Draw::features.
constexpr Features ofLayers(Features bits) {
    return bits << 32;
}
}  // namespace clerestory
