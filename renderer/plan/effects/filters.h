// The passes of the filters that a request asks for.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Adds the passes of every filter that can change something, and says why of the others. `picture`
// holds the finished picture, linear radiance, and `exposureFactor` is what tone mapping will
// multiply it by; returns the target that holds the filtered one.
TargetId planFilters(FramePlan& plan, const std::vector<FilterRequest>& filters, TargetId picture,
                     float exposureFactor);

// For a request whose output is not colour.
void explainFilters(FramePlan& plan, const std::vector<FilterRequest>& filters);

}  // namespace clerestory
