// Scenes of mirrors and glass, and what layers show of them.
#pragma once

#include "support.h"

namespace clerestory::test {

Image layer(FrameRequest r, Channel channel, OutputLayer which);

// At a place, turned about Y by half a turn: a quad() there faces -Z.
glm::dmat4 facingBack(double x, double y, double z);

// A mirror in the plane z = 0 and, behind the eye at z = 2, a square at z = 3 that faces it.
FrameRequest mirrorAndSquare();
// A pane before a square, or a solid block of glass.
FrameRequest glassBefore(bool solid);

}  // namespace clerestory::test
