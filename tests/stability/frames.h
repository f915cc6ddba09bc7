// Scenes and frames of the rows that need a renderer. Every frame is examined: all levels of all
// float targets are searched for non-finite and negative values.
#pragma once

#include "measures/measured_pixels.h"
#include "tests/gl/sight.h"
#include "tests/stability/table.h"

#include <string>

namespace clerestory::test {

class FrameRows : public GlTest {};

// Draws, and adds the frame's health to the row "non-finite scan".
Image drawn(const FrameRequest& request);

// The greatest difference of two pictures over all samples.
double mostApart(const Image& a, const Image& b);
// PSNR in decibels of images whose white is 1; 200 if equal.
double decibelsApart(const Image& a, const Image& b);

// Means over squares of `edge` pixels: hard edges fall between pixels otherwise, and a picture that
// is accidentally blurred beats a sharp one. A square is in the mask if all of it is.
Image averaged(const Image& image, std::uint32_t edge);
Mask whole(const Mask& mask, std::uint32_t edge);

// Three lamps above a mirror floor (the plane z = 0) with a mirror ball and a pane, in `world`.
// mirroredCopy: mirrored lights in place of the floor. extras: ball and pane.
Scene floorScene(const glm::dmat4& world, bool mirroredCopy, bool extras);
// Every effect served by pictures, small ones, under a white sky.
FrameRequest byPictures(Scene scene, const std::string& id, const glm::dvec3& eye);

}  // namespace clerestory::test
