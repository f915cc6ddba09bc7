// Formulae for child views: mirrored views, parts of a picture, the six faces of a cube. Double
// precision, and relative to the eye where the distance from the origin would cost precision.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/visibility/visibility.h"
#include "scene/geometry.h"

#include <array>

namespace clerestory {

// The reflection x - 2 (n.x + offset) n: its own inverse, determinant -1; points of the plane are
// fixed.
glm::dmat4 householder(const Plane& plane);

// Signed distance from the mirror to the eye, metres; positive in front. For an orthographic view:
// 1 if it sees the front, -1 if it sees the back, 0 if it is parallel to the plane.
double eyeHeight(const Plane& plane, const View& view);

// Returns true if the eye is so close to the plane that the mirror covers less than one row of
// pixels. eyeHeight: metres, at least 0; pictureHeight: pixels.
bool edgeOn(double eyeHeight, const View& view, std::uint32_t pictureHeight);

// The view from the mirrored eye, clipped at the mirror. Its pixels coincide with those of `view`
// (erratum P6: V R, not a look-at). The front of the plane must face the eye of `view`.
View mirroredView(const View& view, const Plane& plane);

// A part of a picture in whole pixels from its lower left corner; may extend beyond the picture.
struct PixelRect {
    double x = 0.0, y = 0.0, width = 1.0, height = 1.0;
    bool operator==(const PixelRect&) const = default;
};
// The pixels that a rectangle on screen touches, extended by `guard` pixels on each side.
PixelRect pixelRect(const ScreenBox& box, std::uint32_t width, std::uint32_t height, double guard);
// The part of it within the picture, at least one pixel.
TargetRect touchedPixels(const ScreenBox& box, std::uint32_t width, std::uint32_t height,
                         double guard);

// The smallest rectangle that contains `rect` and whose borders are multiples of `edge` pixels. The
// texels of its smaller levels then do not depend on the exact borders.
PixelRect alignedToGrid(const PixelRect& rect, double edge);

// The view whose picture is `part` of the picture of `view`, which has width x height pixels.
View cropped(const View& view, const PixelRect& part, std::uint32_t width, std::uint32_t height);

// The views of the six faces of a cube at `center` (world) in OpenGL's order (4.3 core,
// table 8.18); the columns of worldFromCube are the axes of the cube. The t coordinate of a face
// increases with the y coordinate of its picture. Reversed depth, infinite far plane; znear in
// metres.
std::array<View, 6> cubeFaceViews(const glm::dvec3& center, double znear,
                                  const glm::dmat3& worldFromCube);

}  // namespace clerestory
