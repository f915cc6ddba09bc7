// The parts of the meadow. Each function adds geometry, materials and a clip.
#pragma once

#include "scene/scene.h"

namespace clerestory::meadow_parts {

// Radius of the fox's path around the origin, metres.
inline constexpr double kPathRadius = 2.1;

// A pole at `foot`, and a flag of 1.9 m by 1.25 m that waves along +X in clip "flag", 2 seconds.
void addFlag(Scene& scene, const glm::dvec3& foot);

// A fox on a path around the origin: clip "walk" moves its legs, clip "round" moves it along the
// path.
void addFox(Scene& scene);

}  // namespace clerestory::meadow_parts
