// The list of built-in scenes.
#include "scene/builtin/builtin_scenes.h"

namespace clerestory {

std::vector<BuiltinScene> builtinScenes() { return {}; }

std::optional<Scene> makeBuiltinScene(const std::string& /*id*/) { return std::nullopt; }

}  // namespace clerestory
