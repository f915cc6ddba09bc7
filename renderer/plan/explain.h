// Reasons why a frame omits an effect, the sky or its light. Each effect records the reasons for
// single objects itself.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// Appends to plan.skipped. `seen`: the surfaces in the root view.
void explainOmissions(FramePlan& plan, const Stage& stage, const SeenView& seen);

}  // namespace clerestory
