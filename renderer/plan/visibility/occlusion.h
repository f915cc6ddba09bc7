// What stands wholly behind a wall: exact for walls of two triangles, silent about all others.
// Boxes here are relative to the eye (the world's axes), as in plan/visibility/visibility.h.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// A parallelogram that nothing is seen through; places relative to the eye.
struct Wall {
    glm::dvec3 corner{0.0}, edge1{0.0}, edge2{0.0};
    std::size_t surface = 0;  // of Stage::surfaces
};

// The walls that a view draws: opaque surfaces of two triangles that face the eye. Perspective
// views without a clip plane; none for others.
std::vector<Wall> wallsOf(const Stage& stage, const View& view);

// The wall that hides the whole box from the eye, if one does.
const Wall* hiding(std::span<const Wall> walls, const View& view, const Bounds& box);

}  // namespace clerestory
