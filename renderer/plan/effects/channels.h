// Frames of numbers instead of colour: depth, normals, identities.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Sets Draw::through of every surface by the method that the effects chose for it, for the channel
// of that name.
void labelThrough(SeenView& seen);

// Adds the pass that draws the numbers of `seen` into `target`.
void planChannel(FramePlan& plan, const View& view, const SeenView& seen, TargetId target);

}  // namespace clerestory
