// Flat mirrors of a view, with the environment map, a mirrored view or rays.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every flat mirror in the view, plans mirrored views, and marks the surfaces
// of `seen` with the features and the picture in `drawn.reflections` that they read.
void planPlanarReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn);

}  // namespace clerestory
