// What a view can see: frusta against boxes, and how much of the picture a box covers.
// Boxes here are relative to the eye (world axes), so that distance from the origin costs nothing.
#pragma once

#include "plan/frame_plan.h"

#include <array>

namespace clerestory {

struct Frustum {
    std::array<glm::dvec4, 6>
        planes;  // inside: dot(plane.xyz, p) + plane.w >= 0; p relative to the eye
};

Frustum frustumOf(const View& view);

// True when the whole box lies behind one plane. A box may be called visible that is not; never
// the other way round.
bool outside(const Frustum& frustum, const Bounds& box);

// Share of the picture, 0..1, that the box's rectangle on screen covers. 1 when it reaches the eye.
double screenShare(const View& view, const Bounds& box);

// From the eye to the nearest point of the box; 0 inside.
double distanceTo(const Bounds& box);

// Moves a place of the world to the eye: eye-relative world axes.
glm::dmat4 eyeFromLocal(const View& view, const glm::dmat4& worldFromLocal);

}  // namespace clerestory
