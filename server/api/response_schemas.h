// JSON Schemas of what the server answers, for /openapi.json. Those of requests are made from the
// field tables; see frame_schema.cpp. Tests hold every one against real answers.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

// By the names under components/schemas: Problem, Job, Plan, Scene, SceneList, Renderer, Status.
nlohmann::ordered_json responseSchemas();

}  // namespace clerestory
