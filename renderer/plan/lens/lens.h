// The lenses of cameras whose pictures are not those of a plane: directions of pixels and pixels of
// directions, each the exact inverse of the other, in double precision.
//
//     const Lens lens = lensFor(request, intrinsics, 1280, 720);
//     const std::optional<glm::dvec3> ray = rayOf(lens, {640.0, 360.0});
//
// Pixels are counted from the upper left corner of the picture, y downwards; the first pixel is
// centred at 0.5, 0.5. Directions are in the camera's axes: +X right, +Y up, and it looks along -Z.
//
// Sources: OpenCV's documentation of calib3d (Brown 1966, Conrady 1919; Kannala and Brandt 2006 for
// the fisheye), docs/camera.md for all formulae.
#pragma once

#include "plan/request/frame_request.h"

#include <array>
#include <optional>

namespace clerestory {

struct Lens {
    // Perspective with distortion, equirectangular, cube or fisheye; `fov` of a fisheye is set.
    LensRequest model;
    Intrinsics intrinsics;  // of a perspective or fisheye lens, pixelCenter half
    std::uint32_t width = 1, height = 1;
    double maxRadius = 0.0;  // perspective: undistorted tangents within which it is injective
    bool operator==(const Lens&) const = default;
};

// Whether the request's lens needs a Lens: false for perspective without distortion and for
// orthographic ones, which one projection matrix draws.
bool needsLens(const LensRequest& lens);

// `intrinsics` of the request, or of its yfov; a fisheye without any has those of its image circle.
// Throws InvalidRequest, with the field and the greatest valid radius, for distortion that shows
// one direction at two points of the frame, or that leaves pixels of the frame without a direction.
Lens lensFor(const LensRequest& lens, const std::optional<Intrinsics>& intrinsics,
             std::uint32_t width, std::uint32_t height);

// Unit direction; none outside of the image circle or of the faces of a cross.
std::optional<glm::dvec3> rayOf(const Lens& lens, const glm::dvec2& pixel);

// Any length but 0; none for a direction that the lens shows nowhere, in the frame or beyond it.
// A panorama shows every direction once, directly up and down at one of the places.
std::optional<glm::dvec2> pixelOf(const Lens& lens, const glm::dvec3& direction);

// What the channel depth holds for a point in this unit direction at a distance of 1: its
// z coordinate for perspective lenses, 1 for all others.
double depthPerDistance(const Lens& lens, const glm::dvec3& direction);

// Axes of the six faces of a cube lens in the camera's axes: right, up and back of each picture.
// Right (+X), left, up (+Y), down, back (+Z), front.
enum CubeFace { cubeRight, cubeLeft, cubeUp, cubeDown, cubeBack, cubeFront };
const std::array<glm::dmat3, 6>& cubeFaceAxes();

}  // namespace clerestory
