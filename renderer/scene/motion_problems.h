// The part of sceneProblems() for animations and deformations.
#pragma once

#include "scene/scene.h"

namespace clerestory {

// The scene's meshes, nodes and indices must be valid. Empty if all animations are valid.
std::vector<std::string> motionProblems(const Scene& scene);

}  // namespace clerestory
