// The feature bits of shaders/include/features.glsl as C++ constants; see Draw::features.
#pragma once

namespace clerestory {
using uint = unsigned int;
#include "shaders/include/features.glsl"
}  // namespace clerestory
