// Formulae about views that a view asks for: through a mirror, of a part of the picture, into the
// six faces of a cube. All in double and relative to the eye where distance from the origin counts.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/visibility/visibility.h"
#include "scene/plane.h"

#include <array>

namespace clerestory {

// x - 2 (n.x + offset) n: its own inverse, determinant -1, the plane's points stay.
glm::dmat4 householder(const Plane& plane);

// How far the eye stands in front of the mirror, metres; of an orthographic view, whose eye is
// nowhere, 1 or -1 as it looks at its front or back, 0 along it.
double eyeHeight(const Plane& plane, const View& view);

// True when the eye is so near the mirror's plane that all of it covers less than a row of pixels.
bool edgeOn(double eyeHeight, const View& view, std::uint32_t pictureHeight);

// The view from the mirrored eye, clipped at the mirror: its picture lies pixel on pixel over that
// of `view` (erratum P6: V R, never a look-at). plane's front is towards view's eye.
View mirroredView(const View& view, const Plane& plane);

// A part of a picture in whole pixels, from its lower left corner; may reach beyond the picture.
struct PixelRect {
    double x = 0.0, y = 0.0, width = 1.0, height = 1.0;
    bool operator==(const PixelRect&) const = default;
};
// The pixels that a rectangle on screen touches, and `guard` more around it.
PixelRect pixelRect(const ScreenBox& box, std::uint32_t width, std::uint32_t height, double guard);

// The least such rectangle of whole squares of `edge` pixels, which lie in the picture's own grid:
// so the pixels of its smaller levels stay where they are, whatever its borders do.
PixelRect ofWholeSquares(const PixelRect& rect, double edge);

// The view whose picture is that part of a picture of width x height pixels.
View cropped(const View& view, const PixelRect& part, std::uint32_t width, std::uint32_t height);

// OpenGL's cube faces (4.3 core, table 8.18) about a point of the world, in a cube whose axes are
// the columns of worldFromCube. Their pictures are stored as they are drawn: a face's t grows where
// its picture's y does. Reversed depth, infinite.
std::array<View, 6> cubeFaceViews(const glm::dvec3& center, double znear,
                                  const glm::dmat3& worldFromCube);

}  // namespace clerestory
