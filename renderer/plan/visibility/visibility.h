// Conservative visibility tests of boxes against frusta and clip planes, and rectangles that boxes
// cover. Boxes are relative to the eye (world axes), so that the distance from the origin does not
// cost precision.
#pragma once

#include "plan/graph/frame_plan.h"

#include <array>

namespace clerestory {

struct Frustum {
    std::array<glm::dvec4, 6>
        planes;  // inside: dot(plane.xyz, p) + plane.w >= 0; p relative to the eye
};

Frustum frustumOf(const View& view);

// Returns true if the whole box is behind one plane of the frustum. Never true for a visible box;
// may be false for an invisible one.
bool outside(const Frustum& frustum, const Bounds& box);

// Returns true if no part of the box is in front of the view's clip plane, within the precision of
// float boxes: an object that only touches a mirror's plane is not visible in the mirror.
bool clippedAway(const View& view, const Bounds& box);

// A rectangle on screen: -1..1 is the whole picture, y upwards.
struct ScreenBox {
    glm::dvec2 low{1.0}, high{-1.0};  // empty
    bool empty() const { return !(low.x < high.x && low.y < high.y); }
    bool overlaps(const ScreenBox& other) const {
        return low.x < other.high.x && other.low.x < high.x && low.y < other.high.y &&
               other.low.y < high.y;
    }
    double share() const {  // fraction of the picture, 0..1
        return empty() ? 0.0 : 0.25 * (high.x - low.x) * (high.y - low.y);
    }
};

// The rectangle of the picture that the box covers at most. A box that extends behind the eye is
// clipped at the near plane.
ScreenBox screenBox(const View& view, const Bounds& box);

// Of a flat figure: square metres, and the fraction of the picture that it covers, 0..1.
struct FlatExtent {
    double area = 0.0, share = 0.0;
};
// Of the part of the plane inside the box; both relative to the eye. Zero if they do not meet.
FlatExtent flatExtent(const View& view, const Bounds& box, const Plane& plane);

// Distance from the eye to the nearest point of the box, metres; 0 if the eye is inside.
double distanceTo(const Bounds& box);

// The transform to positions relative to the eye, world axes.
glm::dmat4 eyeFromLocal(const View& view, const glm::dmat4& worldFromLocal);

}  // namespace clerestory
