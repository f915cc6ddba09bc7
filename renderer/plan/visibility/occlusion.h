// Occlusion of boxes by parallelograms of two triangles. Conservative: other surfaces are not
// considered. Boxes and points are relative to the eye (world axes), as in visibility.h.
#pragma once

#include "plan/visibility/draws.h"

namespace clerestory {

// An opaque parallelogram, relative to the eye.
struct Occluder {
    glm::dvec3 corner{0.0}, edge1{0.0}, edge2{0.0};
    std::size_t surface = 0;  // index of Stage::surfaces
};

// The occluders that a view draws: opaque surfaces of two triangles that face the eye. Empty for
// orthographic views and views with a clip plane.
std::vector<Occluder> occludersOf(const Stage& stage, const View& view);

// Returns an occluder that hides the whole box from the eye; null if there is none.
const Occluder* findOccluder(std::span<const Occluder> occluders, const View& view,
                             const Bounds& box);

}  // namespace clerestory
