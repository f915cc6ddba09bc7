// What a view can see: frusta against boxes, and how much of the picture a box covers.
// Boxes here are relative to the eye (world axes), so that distance from the origin costs nothing.
#pragma once

#include "plan/graph/frame_plan.h"

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

// True when none of the box reaches in front of the view's clip plane, but for what float boxes
// cannot say: what only touches a mirror's plane is not in the mirror.
bool clippedAway(const View& view, const Bounds& box);

// A rectangle on screen: -1..1 is the whole picture, y upwards.
struct ScreenBox {
    glm::dvec2 low{1.0}, high{-1.0};  // empty
    bool empty() const { return !(low.x < high.x && low.y < high.y); }
    bool overlaps(const ScreenBox& other) const {
        return low.x < other.high.x && other.low.x < high.x && low.y < other.high.y &&
               other.low.y < high.y;
    }
    double share() const {  // of the picture
        return empty() ? 0.0 : 0.25 * (high.x - low.x) * (high.y - low.y);
    }
};

// What the box can cover of the picture; of a box that reaches behind the eye, what is beyond the
// near plane.
ScreenBox screenBox(const View& view, const Bounds& box);

// From the eye to the nearest point of the box; 0 inside.
double distanceTo(const Bounds& box);

// Moves a place of the world to the eye: eye-relative world axes.
glm::dmat4 eyeFromLocal(const View& view, const glm::dmat4& worldFromLocal);

}  // namespace clerestory
