// What rays need of the scene, in frames where some draw follows rays.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// Sets plan.rays when some pass of the plan follows rays.
void planRays(FramePlan& plan, const Stage& stage);

}  // namespace clerestory
