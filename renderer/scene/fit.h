// Where an eye must be so that surfaces fill a frame, from a given direction: exactly, for their
// corners as they are, not for a sphere or a box around them.
//
//     const ViewAxes axes = uprightAxes(directionTo(azimuth, elevation));
//     const glm::dvec3 eye = fittedEye(cornersOf(scene, pose), axes, {0.5, 0.5, 0.3, 0.3});
#pragma once

#include "scene/scene.h"

#include <cstddef>
#include <span>
#include <vector>

namespace clerestory {

// Of a camera, which looks along -back: unit, orthogonal, right-handed.
struct ViewAxes {
    glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};
};

// World +Y points up in the picture; along +Y, world -Z does. back: unit.
ViewAxes uprightAxes(const glm::dvec3& back);

// From the middle of the surfaces towards the eye: unit. azimuth: radians about +Y from +Z towards
// +X; elevation: radians above the horizon, from -pi/2 to pi/2.
glm::dvec3 directionTo(double azimuth, double elevation);

// World positions of the corners, three for each triangle, line and point of the instances that
// `chosen` marks (the last one of lines and points is repeated); an empty list marks all. Of more
// than `most` corners, those of every n-th of them.
std::vector<glm::dvec3> cornersOf(const Scene& scene, const Pose& pose,
                                  const std::vector<bool>& chosen = {},
                                  std::size_t most = 4'000'000);

// Tangents of the angles between the axis and the sides of the frame, each above 0; the sum of two
// opposite ones is above 0 for a lens whose axis lies outside of the frame.
struct FrameTangents {
    double left = 0.0, right = 0.0, bottom = 0.0, top = 0.0;
};

// The nearest eye from which every corner is in the frame, in its middle: along one direction two
// corners touch opposite sides. At least a hundredth of their extent in front of the nearest one; a
// metre if they are all one point.
// corners: at least one.
glm::dvec3 fittedEye(std::span<const glm::dvec3> corners, const ViewAxes& axes,
                     const FrameTangents& frame);

// Corners of what the given ones cover while they turn about the vertical axis through the middle
// of their box: fittedEye() of them is as far from the axis for every azimuth of `axes`. A ring is
// a polygon around the circle, which is at most 0.13 % larger. corners: at least one.
std::vector<glm::dvec3> turnedCorners(std::span<const glm::dvec3> corners, const ViewAxes& axes);

}  // namespace clerestory
