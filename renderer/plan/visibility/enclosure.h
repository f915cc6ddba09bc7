// How far a place is cut off from the sky, from boxes alone: what an environment map shows there is
// not what stands around it.
#pragma once

#include "scene/bounds.h"

#include <span>

namespace clerestory {

// Share of the directions around `place`, 0..1, in which some box stands; boxes that hold the place
// itself do not count. All in one space, of any unit. 14 directions: the axes and the diagonals.
double enclosure(std::span<const Bounds> boxes, const glm::dvec3& place);

}  // namespace clerestory
