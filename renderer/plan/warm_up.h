// A plan's programs without its pictures: what to draw so that a driver compiles everything the plan
// will use.
//
//     for (const FramePlan plan = warmUpPlan(planFrame(...)); ...)  // draw each pass once
#pragma once

#include "plan/frame_plan.h"

namespace clerestory {

// Small targets, none resident; every combination of program, material and pass once, each program in
// a pass of its own. Passes stay in their order. What they draw is of no use.
FramePlan warmUpPlan(const FramePlan& plan);

}  // namespace clerestory
