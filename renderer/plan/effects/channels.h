// Frames of a data channel instead of colour: depth, normals, identifiers.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Sets the value of the channel `through` of every surface from the method that was chosen for it.
void labelThrough(SeenView& seen);

// Adds the pass that draws plan.channel of the surfaces in `seen` into `target`.
void planChannel(FramePlan& plan, const View& view, const SeenView& seen, TargetId target);

}  // namespace clerestory
