// Effect: shadows of punctual lights. The scene is drawn from each light into tiles of one shadow
// map, which stays resident until something that it shows changes. Casters that clips do not change
// are drawn once, into a map with which the others begin. A sun over a large scene has nearer
// pictures too, which follow the observer in steps.
#pragma once

#include "plan/effects/near_shadows.h"
#include "plan/graph/frame_context.h"
#include "plan/graph/plan_builder.h"
#include "plan/graph/stage.h"

namespace clerestory {

// Adds a shadow to each light of the plan for which the cost model favours one, and the passes that
// draw the map. Nothing is added if the request has no shadows or nothing can cast one.
// pixels: of the frame.
void planShadows(FramePlan& plan, PlanBuilder& builder, const FrameContext& context,
                 const Stage& stage, const Observer& observer, double pixels);

}  // namespace clerestory
