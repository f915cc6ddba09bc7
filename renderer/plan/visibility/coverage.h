// How much of the picture a surface covers, from what is known of it without looking at its
// triangles: the rectangles of its clusters, and its area.
#pragma once

#include "plan/visibility/visibility.h"
#include "scene/plane.h"

#include <optional>
#include <span>

namespace clerestory {

// A box's rectangle on screen covers more than the surface in it does.
inline constexpr double kBoxFill = 0.4;

// Share of the picture, 0..1, that rectangles cover together; what several cover counts once. At
// each rectangle's edges up to a 64th of what all of them reach is counted too much.
double unionShare(std::span<const ScreenBox> boxes);

// The most that a surface of `area` (square metres) covers of the picture when nothing of it is
// nearer than its box is; above 1 where that says nothing. plane: relative to the eye, of a flat
// surface; any other is taken to be closed, so that half of it at most faces the eye.
double areaShare(const View& view, const Bounds& box, double area,
                 const std::optional<Plane>& plane);

// Square metres of a surface after a transform. normal: mesh space, of a flat surface; the area of
// any other grows with the mean of the transform's scales.
double transformedArea(const glm::dmat4& worldFromMesh, double area,
                       const std::optional<glm::dvec3>& normal);

// The least of the three guesses, 0..1.
double shareOf(const View& view, std::span<const ScreenBox> clusters, const Bounds& box,
               double area, const std::optional<Plane>& plane);

}  // namespace clerestory
