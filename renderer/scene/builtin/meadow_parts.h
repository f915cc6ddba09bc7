// The parts of the meadow; each appends what it is made of and a clip of its own.
#pragma once

#include "scene/scene.h"

namespace clerestory::meadow_parts {

// Radius of the path that the fox walks, about the origin, and how often it goes round.
inline constexpr double kPathRadius = 2.1;

// A pole at `foot`, and a flag of 1.9 m by 1.25 m that waves along +X in clip "flag", 2 seconds.
void addFlag(Scene& scene, const glm::dvec3& foot);

// A fox on a path about the origin: clips "walk", its legs, and "round", its way.
void addFox(Scene& scene);

}  // namespace clerestory::meadow_parts
