// Properties of the scene for ray tracing; see graph/ray_scene.h.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// Sets plan.rays if a pass of the plan traces rays. Call it after all views are planned.
void planRays(FramePlan& plan, const Stage& stage);

}  // namespace clerestory
