// Rays of a picture, from the numbers of a View and by this file's own formulae.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory::reference {

struct CameraRay {
    glm::dvec3 origin{0.0};     // relative to the eye, world axes: not 0 only if orthographic
    glm::dvec3 direction{0.0};  // unit
    double nearest = 0.0, farthest = 0.0;  // metres along it
};

class Lens {
public:
    Lens(const View& view, std::uint32_t width, std::uint32_t height);

    // Through the point (x, y) of the picture, pixels from its upper left corner.
    CameraRay through(double x, double y) const;

private:
    glm::dmat3 worldFromCamera_;
    glm::dvec2 scale_{1.0}, shift_{0.0};  // slopes (metres, if orthographic) at the picture's edges
    glm::dvec2 size_{1.0};
    bool orthographic_ = false;
    double znear_ = 0.0, zfar_ = 0.0;
};

}  // namespace clerestory::reference
