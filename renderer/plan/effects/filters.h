// The passes of the requested filters.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Adds the passes of every filter that can change the picture, and records why others are left out.
// `picture` holds the finished picture as linear radiance, which tone mapping multiplies by
// `exposureFactor`. Returns the target that holds the filtered picture.
TargetId planFilters(FramePlan& plan, const std::vector<FilterRequest>& filters, TargetId picture,
                     float exposureFactor);

// Records that the filters are left out because the output is not colour.
void explainFilters(FramePlan& plan, const std::vector<FilterRequest>& filters);

}  // namespace clerestory
