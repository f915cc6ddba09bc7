// What stands around a surface: how much of its surroundings is not sky.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Share of the directions around the middle of the box (relative to the root's eye) that geometry
// closes, 0..1; 0 in child views, which would need it for every one of their faces.
double enclosureAt(ViewContext& context, const ViewTask& task, const Bounds& box);

}  // namespace clerestory
