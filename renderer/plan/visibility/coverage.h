// Estimates of the fraction of the picture that a surface covers, from the bounding rectangles of
// its clusters and its area, without its triangles.
#pragma once

#include "plan/visibility/visibility.h"
#include "scene/geometry.h"

#include <optional>
#include <span>

namespace clerestory {

// Typical fraction of the bounding rectangle of a cluster that its surface covers.
inline constexpr double kBoxFill = 0.4;
// Typical fraction of a flat surface that nothing hides. Measured, hidden parts included: chapel
// 0.52, orbiting-cubes 0.70, meadow 0.76, a room 0.49, ClearCoatTest 0.58.
inline constexpr double kFlatUnhidden = 0.65;

// Fraction of the picture, 0..1, that the union of rectangles covers. It is computed on a grid of
// 64 cells per axis over the bounds of all rectangles and never too small.
double unionShare(std::span<const ScreenBox> boxes);

// The fraction of the picture that a convex body with a surface of `area` (square metres) inside
// `box` (relative to the eye) covers; above 1 if the area gives no estimate.
double areaShare(const View& view, const Bounds& box, double area);

// Area of a surface after a transform, square metres. normal: of a flat surface, in mesh space;
// other surfaces are scaled by the geometric mean of the scales of the transform.
double transformedArea(const glm::dmat4& worldFromMesh, double area,
                       const std::optional<glm::dvec3>& normal);

// The smallest of the three estimates for a surface that is not flat, 0..1. Boxes are relative to
// the eye.
double shareOf(const View& view, std::span<const ScreenBox> clusters, const Bounds& box,
               double area);

}  // namespace clerestory
