// Glass of a view, over the environment map or a backdrop or with rays, and the passes of its
// layers.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every piece of glass in the view and marks its surfaces.
void chooseRefraction(ViewContext& context, const ViewTask& task, SeenView& seen);

// Adds the passes of glass over a backdrop and of blended surfaces in front of it. `behind` is the
// pass of the view without glass; `through` starts with glass and is sorted far to near.
void addGlassLayers(ViewContext& context, const ViewTask& task, const SeenView& seen,
                    const DrawScene& behind, std::span<const DrawLists::Behind> through);

}  // namespace clerestory
