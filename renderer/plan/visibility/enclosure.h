// How much of the sky geometry blocks at a point, from bounding boxes only. Where it blocks much,
// an environment map does not resemble the surroundings.
#pragma once

#include "plan/graph/stage.h"
#include "scene/geometry.h"

#include <span>
#include <vector>

namespace clerestory {

// Fraction of the directions from `position`, 0..1, that intersect a box; boxes that contain the
// position do not count. Boxes and position are in one space of any unit. 14 directions are tested:
// the axes and the diagonals.
double enclosure(std::span<const Bounds> boxes, const glm::dvec3& position);

// Boxes of all clusters of the scene except glass; relative to the eye of the view, world axes.
std::vector<Bounds> opaqueBoxes(const Stage& stage, const View& view);

}  // namespace clerestory
