// From linear radiance to display colour: tone mapping, then the edge filter.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/request/frame_request.h"

namespace clerestory {

// Adds the passes and sets plan.output. `radiance` holds the finished picture, which is multiplied
// by exposureFactor; the display pictures are in `storage`.
void planDisplay(FramePlan& plan, const FrameRequest& request, TargetId radiance,
                 float exposureFactor, Storage storage);

}  // namespace clerestory
