// Curved mirrors of a view: rendered by the environment map, a captured cube or rays; and rough
// metals, which add up several directions of a map.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every curved mirror that the view shows, captures cubes, and marks the
// surfaces of `seen` with the features and the picture that they read from `drawn.reflections`.
void planCurvedReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn);

// Marks rough metals that mirror a map, of any kind. Captured faces are blurred themselves.
void planRoughReflections(const ViewContext& context, const ViewTask& task, SeenView& seen);

}  // namespace clerestory
