// Small glowing surfaces by the share that they cover of each pixel (Accuracy::emitterCoverage).
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Adds the pass, if the view shows emitters that it knows. The target holds the opaque surfaces of
// the view and their depths.
void planEmitterCoverage(ViewContext& context, const ViewTask& task, const SeenView& seen);

}  // namespace clerestory
