// Glass of a view: how each piece is rendered, and the passes of the layers behind which something
// is seen.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Chooses a method for every piece of glass that the view shows and marks its surfaces.
void chooseRefraction(ViewContext& context, const ViewTask& task, SeenView& seen);

// Adds the passes of glass over a backdrop, and of what is blended in front of it. `behind` is the
// view's pass without glass; `through` starts with glass and is sorted far to near.
void addGlassLayers(ViewContext& context, const ViewTask& task, const SeenView& seen,
                    const DrawScene& behind, std::span<const DrawLists::Behind> through);

}  // namespace clerestory
