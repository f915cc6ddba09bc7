// Several samples for the pixels of a view in which the picture has contrast (Accuracy::samples).
#pragma once

#include "plan/graph/plan_builder.h"
#include "plan/request/frame_request.h"

namespace clerestory {

// Adds the pass, if the request has several samples. `target` holds the finished picture of a
// requested view, and the passes of the view are those from `firstPass` on.
void planSupersampling(PlanBuilder& builder, std::size_t firstPass, TargetId target,
                       const FrameRequest& request, float exposureFactor);

}  // namespace clerestory
