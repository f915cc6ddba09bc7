// A plan's programs without its pictures: what to draw so that a driver compiles everything the
// plan will use.
//
//     for (const FramePlan plan = warmUpPlan(planFrame(...)); ...)  // draw each pass once
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Small targets; every combination of program, material and pass once, each program in a pass of
// its own. Passes stay in their order. What they draw is of no use, except that environment maps
// are prefiltered as the plan does it, and stay resident.
FramePlan warmUpPlan(const FramePlan& plan);

}  // namespace clerestory
