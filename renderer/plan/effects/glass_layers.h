// The order in which the glass of a view is drawn over copies of what is behind it; see
// docs/architecture/glass-layers.md.
//
//     for (const GlassLayer& layer : glassLayers(task, seen, lists.through)) ...
#pragma once

#include "plan/effects/view_context.h"
#include "plan/visibility/draws.h"

#include <span>
#include <vector>

namespace clerestory {

// Glass that shares a copy, and the blended surfaces in front of it.
struct GlassLayer {
    bool rough = false;  // some of the glass blurs the copy
    std::vector<Draw> glassDraws, blendedDraws;
};

// Far to near. through: as of DrawLists; the first is glass. Shells have two draws for each of
// theirs, of back and of front faces, if the layers suffice.
std::vector<GlassLayer> glassLayers(const ViewTask& task, const SeenView& seen,
                                    std::span<const DrawLists::Behind> through);

}  // namespace clerestory
