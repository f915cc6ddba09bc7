// docs/api.md, generated from the OpenAPI document, and with it from the field tables.
#pragma once

#include <string>

namespace clerestory {

// Markdown: routes, request fields, responses, problem codes.
std::string apiDocument();

}  // namespace clerestory
