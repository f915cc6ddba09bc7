// Flat mirrors of a view: which of them need a picture, and the mirrored views that draw those.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every flat mirror that the view shows, plans mirrored views, and marks the
// surfaces of `seen` with the features and the picture that they read from `drawn.reflections`.
void planPlanarReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn);

}  // namespace clerestory
