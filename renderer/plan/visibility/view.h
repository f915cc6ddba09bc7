// Formulae about cameras: from a request to a View, projections, frusta.
// Clip space has reversed depth in 0..1 (1 near, 0 far or infinite), w > 0 in front of the eye.
#pragma once

#include "plan/graph/frame_plan.h"

#include <optional>

namespace clerestory {

// The view a request asks for. Throws InvalidRequest when it names a camera the scene lacks.
// The rotation is rounded to 2^-30, so that the look-at, quaternion and matrix forms of one pose
// give the same bits.
View requestedView(const CameraRequest& camera, const Scene& scene, const Pose& pose,
                   std::uint32_t width, std::uint32_t height);

inline constexpr double kDefaultYfov = 0.9;  // radians, where neither request nor scene says

// World from camera, of a pose that the request itself gives; none for a camera of the scene's and
// for the default view. The request has no problems().
std::optional<glm::dmat4> worldFromPose(const CameraRequest& camera);

// World from camera, looking from position to target. Never NaN: an `up` along the line of sight
// is replaced by -Z (or +Y when that lies along it too).
glm::dmat4 worldFromLookAt(const glm::dvec3& position, const glm::dvec3& target,
                           const glm::dvec3& up);

// yfov in radians, the whole vertical angle; no zfar: infinite.
glm::dmat4 perspective(double yfov, double aspect, double znear, std::optional<double> zfar);
glm::dmat4 perspective(const Intrinsics& lens, std::uint32_t width, std::uint32_t height,
                       double znear, std::optional<double> zfar);
// The inverse: the lens of a perspective view, with pixelCenter half.
Intrinsics lensOf(const glm::dmat4& clipFromView, std::uint32_t width, std::uint32_t height);
// The same view with another far end (znear < zfar); perspective views only.
View withFar(const View& view, double zfar);
glm::dmat4 orthographic(double halfWidth, double halfHeight, double znear, double zfar);

}  // namespace clerestory
