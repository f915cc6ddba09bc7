// The part of sceneProblems() that is about what moves.
#pragma once

#include "scene/scene.h"

namespace clerestory {

// The scene's meshes, nodes and indices must be sound already. Empty when everything is.
std::vector<std::string> motionProblems(const Scene& scene);

}  // namespace clerestory
