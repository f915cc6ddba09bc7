// JSON -> ComparisonRequest; Comparison -> JSON and Markdown.
#pragma once

#include "comparison/curve.h"

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

// Throws RequestError (422) that lists every wrong field.
ComparisonRequest comparisonRequestFrom(const nlohmann::json& body);

// `pictures`: one link for each setting's error picture, or empty.
nlohmann::ordered_json comparisonJson(const Comparison& comparison,
                                      const std::vector<std::string>& pictures = {});

nlohmann::ordered_json curveJson(const Curve& curve);

// A Markdown table with one row for each setting.
std::string comparisonTable(const Comparison& comparison);

// JSON Schema (2020-12) of the body.
nlohmann::ordered_json comparisonRequestSchema();

}  // namespace clerestory
