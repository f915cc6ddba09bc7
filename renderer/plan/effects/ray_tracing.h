// Rays through the triangles of the scene: where they are followed, and what they need to know.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// The features of a program that traces rays, without the maps of layers for which drivers of
// graphics cards have no samplers.
Features withoutExcessMaps(Features features);
// Applies this to the surfaces that trace rays, and counts the maps.
void leaveOutExcessMaps(SeenView& seen);

// Adds a pass that draws a view. If the processor follows rays, the draws of the pass that have
// rays record them, and a further pass follows them; blended draws then have passes of their own.
void addDrawnPass(ViewContext& context, const ViewTask& task, Pass pass);

// Sets plan.rays if a pass of the plan traces rays or the context needs them. Call it after all
// views are planned.
void planRays(FramePlan& plan, const FrameContext& context, const Stage& stage);

}  // namespace clerestory
