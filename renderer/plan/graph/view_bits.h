// The bits of VIEW in shaders/include/features.glsl: what holds for every draw of a view. Loops
// over lights and reads of uniform blocks cost time per pixel; programs for views without them omit
// both.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// coverage: the background is transparent. surfaceLight: vertices have light of their surroundings.
std::uint32_t viewBits(const FramePlan& plan, const View& view, bool coverage, bool surfaceLight);

}  // namespace clerestory
