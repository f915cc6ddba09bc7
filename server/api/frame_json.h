// JSON (and links) <-> FrameRequest, and FramePlan -> JSON. With its .cpp files the only place that
// knows both. All of it walks the field tables of plan/request/frame_request.h.
#pragma once

#include "renderer.h"
#include "server/base/problem.h"

#include <nlohmann/json_fwd.hpp>

#include <map>
#include <string>
#include <string_view>

namespace clerestory {

inline constexpr std::size_t kMaxJsonBytes = 64 * 1024;
inline constexpr int kMaxJsonDepth = 16;

// Strict JSON: no duplicate keys, at most kMaxJsonDepth deep. Throws RequestError (400, 422).
nlohmann::json strictJson(std::string_view text);

// `defaults` stands for the fields that are left out. Throws RequestError (422) that names every
// wrong field.
FrameRequest frameRequestFrom(const nlohmann::json& body, const FrameRequest& defaults = {});

// The body that a link's query stands for: names are paths joined by dots ("camera.yfov"), any
// name that only one field has ("yfov"), or one of the short names below. Throws RequestError
// (422).
nlohmann::json bodyFromQuery(const std::multimap<std::string, std::string>& query);

// Every knob.
nlohmann::ordered_json accuracyJson(const Accuracy& accuracy);

// Every field, in the table's order: equal requests give equal text.
std::string canonicalText(const FrameRequest& request);

// `times` is empty for a plan that did not run, or holds one entry a pass.
nlohmann::ordered_json planJson(const FramePlan& plan, const std::vector<PassTime>& times = {});
// Sums, and a list of the targets.
nlohmann::ordered_json healthJson(const std::vector<TargetHealth>& health);

// JSON Schemas (2020-12) by the name of the component: "FrameRequest", what it refers to, and
// "Accuracy".
nlohmann::ordered_json frameRequestSchemas();
// The query of a link as OpenAPI parameters.
nlohmann::ordered_json frameQueryParameters();

// "eye" -> "camera.position" and the like.
const std::map<std::string, std::string, std::less<>>& shortQueryNames();

}  // namespace clerestory
