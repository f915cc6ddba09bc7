// Warming up: a small plan whose execution makes the driver compile every program that a frame
// uses.
//
//     const FramePlan warmUp = warmUpPlan(planFrame(...));  // execute each pass once
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Draws every combination of program, material and pass type of `plan` once, into targets of a few
// pixels; each program has a separate pass. Passes keep their order. Only prefiltered environment
// maps are useful results: they have their full size and stay resident.
FramePlan warmUpPlan(const FramePlan& plan);

}  // namespace clerestory
