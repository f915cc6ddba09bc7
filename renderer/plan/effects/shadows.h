// Effect: surfaces hide punctual lights from each other. Lights see the scene into tiles of one
// shadow map, which stays resident until something that it shows changes.
#pragma once

#include "plan/graph/frame_context.h"
#include "plan/graph/plan_builder.h"
#include "plan/graph/stage.h"

namespace clerestory {

// Gives those lights of the plan a shadow whose shadows are worth their price, and adds the passes
// that draw the map. Nothing is added if the request has no shadows or nothing can cast one.
// pixels: of the frame.
void planShadows(FramePlan& plan, PlanBuilder& builder, const FrameContext& context,
                 const Stage& stage, double pixels);

}  // namespace clerestory
