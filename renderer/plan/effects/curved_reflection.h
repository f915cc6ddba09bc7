// Curved mirrors of a view, with the environment map, a captured cube or rays; and rough metals,
// which average several directions of a map.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every curved mirror that the view shows, captures cubes, and marks the
// surfaces of `seen` with the features and the picture that they read from `drawn.reflections`.
void planCurvedReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn);

// Marks rough metals that reflect a map, so that they average several directions. Does nothing in
// captured views, which are blurred anyway.
void planRoughReflections(const ViewContext& context, const ViewTask& task, SeenView& seen);

}  // namespace clerestory
