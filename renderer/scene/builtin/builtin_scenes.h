// Scenes made by our own code: deterministic, no files.
#pragma once

#include "scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace clerestory {

struct BuiltinScene {
    std::string id;
    std::string title;
};

std::vector<BuiltinScene> builtinScenes();  // chapel, six-walls, orbiting-cubes, teapots
std::optional<Scene> makeBuiltinScene(const std::string& id);

}  // namespace clerestory
