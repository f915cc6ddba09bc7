// The documents of the API, generated from the field tables and the response schemas.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace clerestory {

// /openapi.json: OpenAPI 3.1.
nlohmann::ordered_json openApiDocument();
std::string openApiText();

// Methods of a path, as in the header Allow; empty if there is no such path.
std::string methodsOf(const std::string& path);

// docs/api.md: the same as Markdown, and the problem codes.
std::string apiDocument();

// JSON Schemas of responses by name under components/schemas. Tests compare every one with real
// responses. Schemas of requests are generated from the field tables; see frame_schema.cpp.
nlohmann::ordered_json responseSchemas();

}  // namespace clerestory
