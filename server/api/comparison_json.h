// ComparisonRequest <- JSON, and Comparison -> JSON and a table for people.
#pragma once

#include "comparison/curve.h"

#include <nlohmann/json_fwd.hpp>

namespace clerestory {

// Throws RequestError (422) that names every wrong field.
ComparisonRequest comparisonRequestFrom(const nlohmann::json& body);

// `pictures`: a link for each setting's error picture, or none.
nlohmann::ordered_json comparisonJson(const Comparison& comparison,
                                      const std::vector<std::string>& pictures = {});

nlohmann::ordered_json curveJson(const Curve& curve);

// Markdown: a row for each setting.
std::string comparisonTable(const Comparison& comparison);

// JSON Schema (2020-12) of the body.
nlohmann::ordered_json comparisonRequestSchema();

}  // namespace clerestory
