// Frames of a lens that no projection matrix describes: the views of its tiles, and the pass that
// assembles the frame from their pictures.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Texels of tiles for each pixel of the frame, along an edge: pixels are means of more samples.
double tileDensity(Preset preset);

// frame: the requested view; its projection is not used, but its far plane is.
View viewOf(const LensTile& tile, const Lens& lens, const View& frame);

// One task for each tile of plan.lens. Their targets are like `frame`, which is that of the frame
// without a lens.
std::vector<ViewTask> tileTasks(FramePlan& plan, const std::vector<LensTile>& tiles,
                                const ViewTask& frame);

// Adds the pass that draws the frame of plan.lens from the pictures of the tasks. Returns its
// target.
TargetId planAssembly(FramePlan& plan, std::vector<LensTile> tiles,
                      const std::vector<ViewTask>& tasks, const ViewTask& frame);

// Where the tiles chose different methods for one subject, the most accurate of them: a change of
// method at a border between tiles would be visible. By nameOf(Subject).
std::map<std::string, Method> agreedMethods(const std::vector<Decision>& decisions);

}  // namespace clerestory
