// A scene as clients see it: what it holds, which effects it calls for, and why each surface was
// classed so.
#pragma once

#include "server/scenes/scene_library.h"

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

nlohmann::ordered_json sceneSummary(const SceneStatus& status, bool isDefault);
nlohmann::ordered_json sceneDetails(const SceneStatus& status, bool isDefault);

}  // namespace clerestory
