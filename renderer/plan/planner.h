// The one place that decides: scene + request + maps already resident -> FramePlan. Pure.
#pragma once

#include "plan/graph/frame_context.h"
#include "plan/graph/frame_plan.h"

namespace clerestory {

// What there is to say when a request names a clip that the scene does not have.
FieldError noSuchClip(const Scene& scene);

// Pure: equal arguments, equal plans.
//
//     FramePlan plan = planFrame({.scene = scene, .pose = pose, ...}, request);
//
// Throws InvalidRequest when the request names a camera that the scene does not have, or a view
// that cannot be drawn.
FramePlan planFrame(const FrameContext& context, const FrameRequest& request);

}  // namespace clerestory
