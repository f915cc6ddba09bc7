// The passes of a frame in one short line, for a header.
#pragma once

#include "plan/graph/frame_plan.h"

#include <string>

namespace clerestory {

inline constexpr std::size_t kMaxCompactPasses = 1024;

// In the order in which they ran: a pass by its name, a run of one kind as `capture*48`. Where that
// is longer than kMaxCompactPasses, each kind once with its count. Plain ASCII.
std::string compactPasses(const FramePlan& plan);

}  // namespace clerestory
