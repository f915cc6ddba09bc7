// The reasons for what a frame leaves out as a whole; each effect records those of single objects.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// Appends to plan.skipped. `seen`: what the root view shows.
void explainOmissions(FramePlan& plan, const Stage& stage, const SeenView& seen);

}  // namespace clerestory
