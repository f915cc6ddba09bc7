// The passes of a frame as one short line, for the header Clerestory-Passes.
#pragma once

#include "plan/graph/frame_plan.h"

#include <string>

namespace clerestory {

inline constexpr std::size_t kMaxCompactPasses = 1024;

// The names of the passes in order; a run of one kind is written as `capture*48`. If that is longer
// than kMaxCompactPasses, each kind once with its count. Plain ASCII.
std::string compactPasses(const FramePlan& plan);

}  // namespace clerestory
