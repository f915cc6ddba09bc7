#include "reference/camera.h"

#include <limits>

namespace clerestory::reference {

// With m = clipFromView, normalised x is m00 x/w - m20, w = -z, for perspective and m00 x + m30 for
// orthographic views. Depth is reversed: m22 is near / (far - near) and 1 / (far - near).
RayCamera::RayCamera(const View& view, std::uint32_t width, std::uint32_t height)
    : worldFromCamera_(glm::transpose(glm::dmat3(view.viewFromWorld))),
      size_(width, height),
      orthographic_(view.orthographic),
      znear_(view.znear) {
    const glm::dmat4& m = view.clipFromView;
    scale_ = {1.0 / m[0][0], 1.0 / m[1][1]};
    shift_ = orthographic_ ? glm::dvec2(-m[3][0], -m[3][1]) : glm::dvec2(m[2][0], m[2][1]);
    const double depth = m[2][2];
    zfar_ = !(depth > 0.0)  ? std::numeric_limits<double>::infinity()
            : orthographic_ ? znear_ + 1.0 / depth
                            : znear_ * (1.0 + 1.0 / depth);
}

CameraRay RayCamera::generateRay(double x, double y) const {
    const glm::dvec2 ndc(2.0 * x / size_.x - 1.0, 1.0 - 2.0 * y / size_.y);
    const glm::dvec2 at = (ndc + shift_) * scale_;
    if (orthographic_) {
        return {worldFromCamera_ * glm::dvec3(at, 0.0), -worldFromCamera_[2], znear_, zfar_};
    }
    const glm::dvec3 direction(at, -1.0);
    const double perDepth = glm::length(direction);
    return {glm::dvec3(0.0), worldFromCamera_ * (direction / perDepth), znear_ * perDepth,
            zfar_ * perDepth};
}

}  // namespace clerestory::reference
