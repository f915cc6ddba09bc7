// Camera rays of a View, computed independently of the renderer's projection code.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory::reference {

struct CameraRay {
    glm::dvec3 origin{0.0};         // relative to the eye, world axes; 0 for perspective views
    glm::dvec3 direction{0.0};      // unit
    double tMin = 0.0, tMax = 0.0;  // metres
};

class RayCamera {
public:
    RayCamera(const View& view, std::uint32_t width, std::uint32_t height);

    // The ray through image position (x, y), in pixels from the upper left corner.
    CameraRay generateRay(double x, double y) const;

private:
    glm::dmat3 worldFromCamera_;
    glm::dvec2 scale_{1.0}, shift_{0.0};  // slopes (orthographic: metres) at the image's edges
    glm::dvec2 size_{1.0};
    bool orthographic_ = false;
    double znear_ = 0.0, zfar_ = 0.0;
};

}  // namespace clerestory::reference
