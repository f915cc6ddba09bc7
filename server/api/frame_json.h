// JSON and links <-> FrameRequest; FramePlan -> JSON. Only this header and its .cpp files know
// both. They use the field tables of plan/request/frame_request.h.
#pragma once

#include "renderer.h"
#include "server/base/problem.h"

#include <nlohmann/json_fwd.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace clerestory {

inline constexpr std::size_t kMaxJsonDepth = 16;
// Elements of one list, values of one body. A sequence of 16,000 matrices has 304,000 values.
inline constexpr std::size_t kMaxJsonElements = 100'000, kMaxJsonValues = 500'000;

// Strict JSON: no duplicate keys, within these limits. Throws RequestError (400, 422).
nlohmann::json strictJson(std::string_view text);

// Absent fields have their values from `defaults`. Throws RequestError (422) that lists every wrong
// field, after the `errors` that were found before.
FrameRequest frameRequestFrom(const nlohmann::json& body, const FrameRequest& defaults = {},
                              std::vector<FieldError> errors = {});

// The body that corresponds to the query of a link. A name is a path with dots ("camera.yfov"), its
// last part if only one field ends in it ("yfov"), or one of shortQueryNames(). Throws RequestError
// (422).
nlohmann::json bodyFromQuery(const std::multimap<std::string, std::string>& query);
// The same, without the names that are wrong; these are added to `errors`.
nlohmann::json bodyFromQuery(const std::multimap<std::string, std::string>& query,
                             std::vector<FieldError>& errors);

// Every field.
nlohmann::ordered_json accuracyJson(const Accuracy& accuracy);

// Every field in the order of the table: equal requests give equal text.
std::string canonicalText(const FrameRequest& request);

nlohmann::ordered_json cameraJson(const CameraRequest& camera);

// The text of an answer; on one line if `indent` is -1. Invalid UTF-8 is replaced.
std::string jsonText(const nlohmann::ordered_json& json, int indent = -1);

// Pose and lens of a planned frame. Matrices are column-major.
struct FrameCamera {
    glm::dmat4 cameraToWorld{1.0};           // the camera looks along -Z
    std::optional<glm::dmat4> clipFromView;  // of lenses that a matrix describes
    std::uint32_t width = 0, height = 0;     // pixels
    double znear = 0.0;                      // metres
    std::optional<Intrinsics> intrinsics;    // of perspective and fisheye lenses
    LensRequest lens;                        // all its parameters, with the defaults resolved
};
// None if no pass of the plan draws the requested view.
std::optional<FrameCamera> cameraOf(const FramePlan& plan);
nlohmann::ordered_json cameraJson(const FrameCamera& camera);
nlohmann::ordered_json lightJson(const LightProgress& light);

// `times` has one entry for each pass, or is empty for a plan that did not run.
nlohmann::ordered_json planJson(const FramePlan& plan, const std::vector<PassTime>& times = {});
// Target and subject of each map, in the order of the parts of the response.
nlohmann::ordered_json mapsJson(const FramePlan& plan, const std::vector<MapPicture>& maps);
// Sums over the targets, and each target.
nlohmann::ordered_json healthJson(const std::vector<TargetHealth>& health);
// The channel instances; `classes`: of its request.
nlohmann::ordered_json instancesJson(const Frame& frame, const std::vector<ClassPattern>& classes);

// JSON Schemas (2020-12) by the name of the component: "FrameRequest", what it refers to, and
// "Accuracy".
nlohmann::ordered_json frameRequestSchemas();
// The query of a link as OpenAPI parameters.
nlohmann::ordered_json frameQueryParameters();

// Short names of links, such as "eye" -> "camera.position".
const std::map<std::string, std::string, std::less<>>& shortQueryNames();

}  // namespace clerestory
