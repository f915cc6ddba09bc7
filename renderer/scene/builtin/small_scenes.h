// The small built-in scenes, and what tests may rely on in them.
#pragma once

#include "scene/scene.h"

#include <array>

namespace clerestory {

// A closed room, 2 * kSixWallsHalf wide, centred on the origin, of six walls that each emit one
// plain colour and reflect nothing, round a mirror-smooth metal ball of radius 0.5.
inline constexpr float kSixWallsHalf = 2.0f;
inline constexpr std::array<glm::vec3, 6> kSixWallsRadiance = {{
    {1, 0, 0},  // +X red
    {0, 1, 1},  // -X cyan
    {0, 1, 0},  // +Y green
    {1, 0, 1},  // -Y magenta
    {0, 0, 1},  // +Z blue
    {1, 1, 0},  // -Z yellow
}};
Scene sixWalls();

// A mirrored ball with eight cubes that pulsate and go round it: clips "orbit" and "pulse".
Scene orbitingCubes();

// What moves and is mirrored: a flag, a fox that walks, lanterns that circle a ball.
Scene meadow();

// Teapots of different stuff on a table under soft boxes.
Scene teapots();

// The nave: all four effects in one view.
Scene chapel();

}  // namespace clerestory
