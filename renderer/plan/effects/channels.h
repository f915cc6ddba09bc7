// Frames of a data channel instead of colour: depth, normals, identifiers.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Sets the value of the channel `through` of every surface from the method that was chosen for it.
// firstMirror: number of mirrored views of earlier views of the frame. Returns it with those of
// this one added.
std::uint32_t labelThrough(SeenView& seen, std::uint32_t firstMirror = 0);

// Adds the pass that draws plan.channel of the surfaces in `seen`, the root view `task`.
void planChannel(FramePlan& plan, const ViewTask& task, const SeenView& seen);

}  // namespace clerestory
