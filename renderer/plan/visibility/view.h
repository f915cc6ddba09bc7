// Camera formulae: from a request to a View, projections. Angles in radians, distances in metres.
// Clip space has reversed depth in 0..1 (1 near, 0 far or infinite), w > 0 in front of the eye.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/lens/lens.h"

#include <optional>

namespace clerestory {

// The requested view of a frame of width x height pixels. Throws InvalidRequest if the request
// names a camera that the scene does not have. The rotation is rounded to 2^-30, so that the
// look-at, quaternion and matrix forms of one pose give the same bits.
View requestedView(const CameraRequest& camera, const Scene& scene, const Pose& pose,
                   std::uint32_t width, std::uint32_t height);

// The lens of the requested view, if no projection matrix describes it (then that of
// requestedView() is a perspective one with its near and far plane); else none. Throws
// InvalidRequest as lensFor() and requestedView() do.
std::optional<Lens> requestedLens(const CameraRequest& camera, const Scene& scene, const Pose& pose,
                                  std::uint32_t width, std::uint32_t height);

inline constexpr double kFitYfov = 0.7;      // radians; of CameraRequest::fit
inline constexpr double kDefaultYfov = 0.9;  // radians; if neither request nor scene has one

// World from camera for a pose in the request; none for a camera of the scene and for the default
// view. Requires that problems() of the request is empty.
std::optional<glm::dmat4> worldFromPose(const CameraRequest& camera);

// World from camera, looking from position to target. Never NaN: an `up` parallel to the line of
// sight is replaced by -Z, or by +Y if -Z is parallel too.
glm::dmat4 worldFromLookAt(const glm::dvec3& position, const glm::dvec3& target,
                           const glm::dvec3& up);

// yfov: the whole vertical angle, radians; without zfar the far plane is infinite.
glm::dmat4 perspective(double yfov, double aspect, double znear, std::optional<double> zfar);
glm::dmat4 perspective(const Intrinsics& lens, std::uint32_t width, std::uint32_t height,
                       double znear, std::optional<double> zfar);
// The inverse: the intrinsics of a perspective projection, with pixelCenter half.
Intrinsics lensOf(const glm::dmat4& clipFromView, std::uint32_t width, std::uint32_t height);
// The same view with another far plane; znear < zfar. Perspective views only.
View withFar(const View& view, double zfar);
glm::dmat4 orthographic(double halfWidth, double halfHeight, double znear, double zfar);

}  // namespace clerestory
