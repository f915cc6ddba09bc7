// The distortions of lenses and their inverses, to the precision of double numbers.
#pragma once

#include "plan/request/lens_request.h"

#include <glm/glm.hpp>

#include <optional>

namespace clerestory {

// Brown and Conrady, in tangents x / z and y / z with y downwards. It is the gradient of a
// potential: where its Jacobian is positive definite on a disc, which is convex, it is injective
// there, and Newton's method finds the inverse.
glm::dvec2 distorted(const PerspectiveLens& lens, const glm::dvec2& tangents);

// Radius of the greatest disc about the axis on which the Jacobian is positive definite; at most
// kMaxTangent.
double injectiveRadius(const PerspectiveLens& lens);
inline constexpr double kMaxTangent = 1e3;

// The tangents within `radius` that distorted() maps to `at`; none if there are none.
std::optional<glm::dvec2> undistorted(const PerspectiveLens& lens, const glm::dvec2& at,
                                      double radius);

// OpenCV's fisheye: theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8), radians.
double distortedAngle(const FisheyeLens& lens, double theta);
// The greatest angle, at most pi, up to which it increases.
double injectiveAngle(const FisheyeLens& lens);
// Its inverse for 0 <= value <= distortedAngle(lens, most) and most <= injectiveAngle(lens).
double undistortedAngle(const FisheyeLens& lens, double value, double most);

}  // namespace clerestory
