#include "server/api/openapi.h"

#include "server/api/comparison_json.h"
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/api/route_table.h"
#include "server/api/sequence_request.h"
#include "server/base/process.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

ordered_json reference(const char* name) {
    return {{"$ref", "#/components/schemas/" + std::string(name)}};
}

ordered_json jsonContent(ordered_json schema) {
    return {{"application/json", {{"schema", std::move(schema)}}}};
}

// Bytes that are not JSON.
ordered_json binaryContent() {
    return {{"schema", {{"type", "string"}, {"format", "binary"}}}};
}

ordered_json problemAnswer(const char* description) {
    return {{"description", description},
            {"content", {{"application/problem+json", {{"schema", reference("Problem")}}}}}};
}

ordered_json answers(const char* description, ordered_json content) {
    return {{"200", {{"description", description}, {"content", std::move(content)}}},
            {"default", problemAnswer("the error, with every wrong field")}};
}

ordered_json withNotModified(ordered_json answers) {
    answers["304"] = {{"description", "the content has the ETag of If-None-Match"}};
    return answers;
}

ordered_json frameAnswers() {
    ordered_json content = ordered_json::object();
    for (const OutputFormat format : {OutputFormat::jpeg, OutputFormat::png, OutputFormat::npy,
                                      OutputFormat::exr, OutputFormat::webp}) {
        content[std::string(mediaType(format))] = binaryContent();
    }
    content["application/json"] = {{"schema", reference("Instances")}};
    content["multipart/mixed"] = binaryContent();
    ordered_json json = answers("the frame; with explain also its plan", content);
    json["200"]["headers"] = {
        {"Age",
         {{"description", "seconds since the frame was drawn; only for an answer from the cache"},
          {"schema", {{"type", "integer"}, {"minimum", 0}}}}}};
    return withNotModified(std::move(json));
}

ordered_json frameBody() {
    return {{"required", true}, {"content", jsonContent(reference("FrameRequest"))}};
}

ordered_json explainParameter() {
    return {
        {"name", "explain"},
        {"in", "query"},
        {"description",
         "1: a multipart/mixed answer whose second part is the plan with milliseconds; health: "
         "the plan also counts the texels of each float target that are not finite or negative; "
         "maps: the plan is followed by a JPEG of each mirrored view and cube that the frame "
         "reads, named by its target, a cube as +X -X +Y above -Y +Z -Z"},
        {"schema", {{"type", "string"}, {"enum", {"0", "1", "health", "maps"}}, {"default", "0"}}}};
}

ordered_json get(const char* summary, ordered_json responses) {
    return {{"get", {{"summary", summary}, {"responses", std::move(responses)}}}};
}

ordered_json getObject(const char* summary, const char* schema) {
    return get(summary, answers(summary, jsonContent(reference(schema))));
}

ordered_json pathParameters(std::initializer_list<const char*> names) {
    const auto description = [](std::string_view name) {
        return name == "id"       ? "id of the scene or job"
               : name == "number" ? "index from 0"
               : name == "map"    ? "name of the environment map"
                                  : "name of the view: up to 64 letters, digits, - and _";
    };
    ordered_json list = ordered_json::array();
    for (const char* name : names) {
        list.push_back({{"name", name},
                        {"in", "path"},
                        {"required", true},
                        {"description", description(name)},
                        {"schema", {{"type", "string"}}}});
    }
    return list;
}

ordered_json withPathParameters(ordered_json path, std::initializer_list<const char*> names) {
    path["get"]["parameters"] = pathParameters(names);
    return path;
}

ordered_json jobOperation(const char* summary) {
    return {{"summary", summary},
            {"parameters", pathParameters({"id"})},
            {"responses", answers("the job", jsonContent(reference("Job")))}};
}

ordered_json streamParameters() {
    const auto one = [](const char* name, const char* words, ordered_json schema) {
        return ordered_json{
            {"name", name}, {"in", "query"}, {"description", words}, {"schema", std::move(schema)}};
    };
    ordered_json list = frameQueryParameters();
    list.push_back(one("view", "name of a live view", {{"type", "string"}}));
    list.push_back(one("fps", "maximum frames per second; 60 if absent with targetMs",
                       {{"type", "number"}, {"minimum", 0.1}, {"maximum", 60}, {"default", 15}}));
    list.push_back(one("play", "1: the time of the scene advances",
                       {{"type", "string"}, {"enum", {"0", "1"}}}));
    list.push_back(one("targetMs",
                       "target time of a frame in motion in milliseconds: size and preset of these "
                       "frames are chosen from measured times, and 160 ms after the last change "
                       "the frame is refined up to the request; if absent, every frame is the "
                       "request",
                       {{"type", "number"}, {"minimum", 10}, {"maximum", 5000}}));
    return list;
}

// POST of a file. what: "a scene"; done: responses of success, by status.
ordered_json uploadOperation(const std::string& what, const char* description,
                             std::initializer_list<const char*> types, ordered_json done) {
    ordered_json content = ordered_json::object();
    for (const char* type : types) content[type] = binaryContent();
    ordered_json responses = std::move(done);
    const std::string unusable = "the body is not usable as " + what +
                                 ": `reason` is unsupported, malformed, crashed, timedOut, memory "
                                 "or limit";
    responses["422"] = problemAnswer(unusable.c_str());
    responses["507"] = problemAnswer("no space left for uploads");
    responses["default"] = problemAnswer("the error");
    return {{"summary", "Uploads " + what + ", where uploads are allowed"},
            {"description", description},
            {"parameters", ordered_json::array({{{"name", "title"},
                                                 {"in", "query"},
                                                 {"description", "title for people"},
                                                 {"schema", {{"type", "string"}}}}})},
            {"requestBody", {{"required", true}, {"content", std::move(content)}}},
            {"responses", std::move(responses)}};
}

ordered_json scenesPath() {
    ordered_json path = getObject("Lists the scenes", "SceneList");
    const auto scene = [](const char* words) {
        return ordered_json{{"description", words}, {"content", jsonContent(reference("Scene"))}};
    };
    path["post"] = uploadOperation(
        "a scene",
        "The body is a .glb file, a .gltf file with embedded data, a .fbx, .dae, .ply, .stl or "
        ".3ds file, or an archive of one scene and its files. The id is derived from the content. "
        "Uploads are off (403) where limits.uploadBytes of GET /v1/renderer is 0. With Prefer: "
        "respond-async the answer is 202 at once.",
        {"model/gltf-binary", "model/gltf+json", "model/stl", "model/vnd.collada+xml",
         "application/zip", "application/x-tar", "application/gzip", "application/octet-stream"},
        {{"201", scene("the scene is loaded; its path is in Location")},
         {"200", scene("the same content was uploaded before")},
         {"202",
          scene("the scene is loading; GET of its Location reports state, stage and progress")}});
    return path;
}

ordered_json scenePath() {
    ordered_json path = withPathParameters(
        getObject("Describes a scene: contents, the class of each surface with its reason, memory",
                  "Scene"),
        {"id"});
    path["delete"] = {
        {"summary", "Deletes an uploaded scene"},
        {"parameters", pathParameters({"id"})},
        {"responses",
         {{"204", {{"description", "the scene is deleted; frames in progress are finished"}}},
          {"default", problemAnswer("the error")}}}};
    return path;
}

ordered_json environmentsPath() {
    ordered_json path = getObject("Lists the environment maps", "EnvironmentList");
    const auto map = [](const char* words) {
        return ordered_json{{"description", words},
                            {"content", jsonContent(reference("Environment"))}};
    };
    path["post"] = uploadOperation(
        "an environment map",
        "The body is an equirectangular .hdr or .exr file, or a cube map as .ktx, .ktx2 or .dds. "
        "The name is derived from the content; use it as environment.map of a frame.",
        {"image/vnd.radiance", "image/x-exr", "image/ktx", "image/ktx2", "image/vnd-ms.dds",
         "application/octet-stream"},
        {{"201", map("the map is loaded; its path is in Location")},
         {"200", map("the same content was uploaded before")}});
    return path;
}

ordered_json environmentPath() {
    ordered_json path =
        withPathParameters(getObject("Describes an environment map", "Environment"), {"map"});
    path["delete"] = {
        {"summary", "Deletes an uploaded environment map"},
        {"parameters", pathParameters({"map"})},
        {"responses",
         {{"204", {{"description", "the map is deleted; frames in progress are finished"}}},
          {"default", problemAnswer("the error")}}}};
    return path;
}

ordered_json paths() {
    ordered_json query = frameQueryParameters();
    query.push_back(explainParameter());
    return {
        {"/v1/frames",
         {{"post",
           {{"summary", "Draws one frame"},
            {"parameters", ordered_json::array({explainParameter()})},
            {"requestBody", frameBody()},
            {"responses", frameAnswers()}}},
          {"get",
           {{"summary", "Draws one frame from a link"},
            {"description",
             "A name is the path of a field with dots (camera.yfov), or its last part where only "
             "one field ends in it (yfov, target, refraction). eye, camera, environment and "
             "accuracy are short for camera.position, camera.name, environment.map and "
             "accuracy.preset; size=512 or size=640x360 is short for width and height, fit=all for "
             "camera.fit of everything."},
            {"parameters", std::move(query)},
            {"responses", frameAnswers()}}}}},
        {"/v1/plans",
         {{"post",
           {{"summary", "Plans a frame without drawing it"},
            {"requestBody", frameBody()},
            {"responses",
             answers("passes; what was left out and why; the technique of each reflector and "
                     "piece of glass with its alternatives and reason; totals",
                     jsonContent(reference("Plan")))}}}}},
        {"/v1/comparisons",
         {{"post",
           {{"summary", "Measures time and error of accuracy settings"},
            {"description",
             "Starts a job. For each setting its result has milliseconds, the error of the frame "
             "and of the pixels of each effect against a path-traced reference, and the closed "
             "gap."},
            {"requestBody",
             {{"required", true}, {"content", jsonContent(reference("ComparisonRequest"))}}},
            {"responses",
             {{"202",
               {{"description", "the job; its path is in Location"},
                {"content", jsonContent(reference("Job"))}}},
              {"default", problemAnswer("the error, with every wrong field")}}}}}}},
        {"/v1/sequences",
         {{"post",
           {{"summary", "Draws many frames in one answer"},
            {"description",
             "Files are sent as they are drawn, as a tar, or as parts with Accept: "
             "multipart/mixed. Each frame has its pictures, then NNNNNN.json with the matrices of "
             "the camera, plans and milliseconds. manifest.json comes last. Accept: video/mp4 "
             "(H.264) "
             "or image/webp (animated) gives a film of the colour channel instead."},
            {"requestBody",
             {{"required", true}, {"content", jsonContent(reference("SequenceRequest"))}}},
            {"responses", answers("the files", {{kTarType, binaryContent()},
                                                {"multipart/mixed", binaryContent()},
                                                {"video/mp4", binaryContent()},
                                                {"image/webp", binaryContent()}})}}}}},
        {"/v1/views/{name}",
         {{"put",
           {{"summary", "Sets a live view"},
            {"description",
             "Watchers receive the newest request: of those that arrive while a frame is drawn, "
             "only the last one is drawn. The header Clerestory-View-Version of the answer is the "
             "number of this change."},
            {"parameters", pathParameters({"name"})},
            {"requestBody", frameBody()},
            {"responses",
             {{"204", {{"description", "the view is set, and its watchers receive the frame"}}},
              {"default", problemAnswer("the error, with every wrong field")}}}}},
          {"get",
           {{"summary", "Reads a live view"},
            {"parameters", pathParameters({"name"})},
            {"responses",
             answers("the body that was last set", jsonContent(reference("FrameRequest")))}}}}},
        {"/v1/stream",
         {{"get",
           {{"summary", "Streams a view as motion JPEG"},
            {"description",
             "A frame is sent when the view changes. With view the stream shows a live view, "
             "otherwise "
             "the frame of a link. Each part has the header Clerestory-View-Version. With targetMs "
             "it also has Clerestory-Level (0: the request; higher: smaller and cheaper), "
             "Clerestory-Size, Clerestory-Preset (requested or draft) and Server-Timing."},
            {"parameters", streamParameters()},
            {"responses", answers("one part for each picture",
                                  {{"multipart/x-mixed-replace", binaryContent()}})}}}}},
        {"/v1/jobs/{id}",
         {{"get", jobOperation("Reports the progress and the result of a job")},
          {"delete", jobOperation("Cancels a job")}}},
        {"/v1/jobs/{id}/pictures/{number}",
         withPathParameters(get("Returns a picture of a job",
                                answers("the picture", {{"image/png", binaryContent()}})),
                            {"id", "number"})},
        {"/v1/scenes", scenesPath()},
        {"/v1/scenes/{id}", scenePath()},
        {"/v1/environments", environmentsPath()},
        {"/v1/environments/{map}", environmentPath()},
        {"/v1/renderer", getObject("Describes driver, limits and build", "Renderer")},
        {"/healthz", getObject("Reports that the process runs", "Status")},
        {"/readyz",
         getObject(
             "Reports that the default scene is loaded, its shaders are compiled and a frame was "
             "drawn within the last seconds",
             "Status")},
        {"/metrics", get("Returns metrics as Prometheus text",
                         answers("metrics", {{"text/plain", {{"schema", {{"type", "string"}}}}}}))},
        {"/openapi.json", get("Returns the OpenAPI document",
                              withNotModified(answers(
                                  "OpenAPI 3.1", jsonContent({{"type", "object"},
                                                              {"additionalProperties", true}}))))}};
}

// The names of operations in generated clients.
struct OperationId {
    const char *path, *method, *id;
};
constexpr OperationId kOperationIds[] = {
    {"/v1/frames", "post", "renderFrame"},
    {"/v1/frames", "get", "renderLinkedFrame"},
    {"/v1/plans", "post", "planFrame"},
    {"/v1/comparisons", "post", "startComparison"},
    {"/v1/sequences", "post", "renderSequence"},
    {"/v1/views/{name}", "put", "setView"},
    {"/v1/views/{name}", "get", "getView"},
    {"/v1/stream", "get", "streamView"},
    {"/v1/jobs/{id}", "get", "getJob"},
    {"/v1/jobs/{id}", "delete", "cancelJob"},
    {"/v1/jobs/{id}/pictures/{number}", "get", "getJobPicture"},
    {"/v1/scenes", "get", "listScenes"},
    {"/v1/scenes", "post", "uploadScene"},
    {"/v1/scenes/{id}", "get", "getScene"},
    {"/v1/scenes/{id}", "delete", "deleteScene"},
    {"/v1/environments", "get", "listEnvironments"},
    {"/v1/environments", "post", "uploadEnvironment"},
    {"/v1/environments/{map}", "get", "getEnvironment"},
    {"/v1/environments/{map}", "delete", "deleteEnvironment"},
    {"/v1/renderer", "get", "getRenderer"},
    {"/healthz", "get", "getHealth"},
    {"/readyz", "get", "getReadiness"},
    {"/metrics", "get", "getMetrics"},
    {"/openapi.json", "get", "getOpenApi"},
};

ordered_json operations() {
    ordered_json all = paths();
    for (const OperationId& named : kOperationIds) {
        ordered_json& operation = all[named.path][named.method];
        operation["operationId"] = named.id;
        operation["responses"]["4XX"] = problemAnswer("an error of the request");
        const bool open = std::string_view(named.path).ends_with("z");  // health and readiness
        if (open) operation["security"] = ordered_json::array();
    }
    return all;
}

}  // namespace

ordered_json openApiDocument() {
    ordered_json schemas = frameRequestSchemas();
    schemas["ComparisonRequest"] = comparisonRequestSchema();
    schemas["SequenceRequest"] = sequenceRequestSchema();
    schemas.update(responseSchemas());
    return {
        {"openapi", "3.1.0"},
        {"info",
         {{"title", "Clerestory"},
          {"version", versionText()},
          {"description",
           "Draws frames of 3D scenes from camera poses. Lengths are metres, angles radians, times "
           "seconds, colours linear. The world is right-handed with +Y up; a camera looks along "
           "its own -Z axis."},
          {"license", {{"name", "MIT"}, {"identifier", "MIT"}}}}},
        {"servers", {{{"url", "/"}}}},
        // Required only where the server runs with --token-file.
        {"security", {{{"token", ordered_json::array()}}, ordered_json::object()}},
        {"paths", operations()},
        {"components",
         {{"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}},
          {"schemas", std::move(schemas)}}}};
}

std::string openApiText() {
    return openApiDocument().dump();
}

std::string methodsOf(const std::string& path) {
    static const ordered_json paths = openApiDocument()["paths"];
    for (const auto& [pattern, operations] : paths.items()) {
        if (!covers(pattern, path)) continue;
        std::string allow;
        for (const auto& [method, operation] : operations.items()) {
            if (method == "parameters") continue;
            std::string word = method;
            std::transform(word.begin(), word.end(), word.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
            allow += (allow.empty() ? "" : ", ") + word + (word == "GET" ? ", HEAD" : "");
        }
        return allow;
    }
    return {};
}

}  // namespace clerestory
