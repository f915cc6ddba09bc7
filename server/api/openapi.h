// /openapi.json: OpenAPI 3.1, made from the field tables and the table of routes.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

nlohmann::ordered_json openApiDocument();

}  // namespace clerestory
