// A scene as JSON: its contents, the effects that it needs, and the class of each surface with its
// reason.
#pragma once

#include "server/scenes/scene_library.h"

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

nlohmann::ordered_json sceneSummary(const SceneStatus& status, bool isDefault);
nlohmann::ordered_json sceneDetails(const SceneStatus& status, bool isDefault);

}  // namespace clerestory
