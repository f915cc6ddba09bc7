// The built-in scenes, and the constants that tests use.
#pragma once

#include "scene/scene.h"

#include <array>

namespace clerestory {

// A closed room, 2 * kSixWallsHalf wide, centred on the origin. Each of its six walls emits one
// colour and reflects nothing. At the centre is a perfectly smooth metal ball of radius 0.5.
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

// A mirror ball with eight pulsating cubes in orbit: clips "orbit" and "pulse".
Scene orbitingCubes();

// Moving objects with reflections: a flag, a walking fox, lanterns in orbit around a ball.
Scene meadow();

// Teapots of different materials on a table under soft boxes.
Scene teapots();

// A chapel: all four effects in one view.
Scene chapel();

}  // namespace clerestory
