// Curved mirrors of a view, with the environment map, a captured cube or rays; and rough metals,
// which average several directions of a map.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every curved mirror that the view shows, captures cubes, and marks the
// surfaces of `seen` with the features and the picture that they read from `drawn.reflections`.
void planCurvedReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn);

// Marks surfaces that reflect a map and may be rough, so that they make several look-ups where they
// are seen at an angle. Does nothing in captured views, which are blurred anyway.
void planRoughReflections(const ViewContext& context, const ViewTask& task, SeenView& seen);

}  // namespace clerestory
