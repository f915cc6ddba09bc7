#include "server/api/openapi.h"

#include "server/api/comparison_json.h"
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/api/response_schemas.h"
#include "server/api/sequence_request.h"
#include "server/base/build_id.h"
#include "server/live/archive.h"

#include <nlohmann/json.hpp>

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
            {"default", problemAnswer("what went wrong, with every wrong field")}};
}

ordered_json frameAnswers() {
    ordered_json content = ordered_json::object();
    for (const OutputFormat format :
         {OutputFormat::jpeg, OutputFormat::png, OutputFormat::npy, OutputFormat::exr}) {
        content[std::string(mediaType(format))] = binaryContent();
    }
    content["multipart/mixed"] = binaryContent();
    ordered_json json = answers("the frame; with explain=1 the plan follows it", content);
    json["304"] = {{"description", "the frame has the ETag that If-None-Match names"}};
    return json;
}

ordered_json frameBody() {
    return {{"required", true}, {"content", jsonContent(reference("FrameRequest"))}};
}

ordered_json explainParameter() {
    return {
        {"name", "explain"},
        {"in", "query"},
        {"description",
         "1: a multipart/mixed answer whose second part is the plan that ran; health: and in "
         "it how many texels of every float target are not finite or hold negative light; maps: "
         "after it a JPEG of every mirrored view and cube that the frame reads, named by its "
         "target; a cube as +X -X +Y above -Y +Z -Z"},
        {"schema", {{"type", "string"}, {"enum", {"0", "1", "health", "maps"}}, {"default", "0"}}}};
}

ordered_json get(const char* summary, ordered_json responses) {
    return {{"get", {{"summary", summary}, {"responses", std::move(responses)}}}};
}

ordered_json getObject(const char* summary, const char* schema) {
    return get(summary, answers(summary, jsonContent(reference(schema))));
}

ordered_json pathParameters(std::initializer_list<const char*> names) {
    ordered_json list = ordered_json::array();
    for (const char* name : names) {
        list.push_back(
            {{"name", name}, {"in", "path"}, {"required", true}, {"schema", {{"type", "string"}}}});
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
    list.push_back(one("view", "a live view's name", {{"type", "string"}}));
    list.push_back(one("fps", "most frames a second",
                       {{"type", "number"}, {"minimum", 0.1}, {"maximum", 60}, {"default", 15}}));
    list.push_back(one("play", "1: time runs", {{"type", "string"}, {"enum", {"0", "1"}}}));
    return list;
}

ordered_json scenesPath() {
    ordered_json path = getObject("What can be rendered", "SceneList");
    const auto scene = [](const char* words) {
        return ordered_json{{"description", words}, {"content", jsonContent(reference("Scene"))}};
    };
    ordered_json content = ordered_json::object();
    for (const char* type : {"model/gltf-binary", "model/gltf+json", "application/zip",
                             "application/x-tar", "application/gzip", "application/octet-stream"}) {
        content[type] = binaryContent();
    }
    path["post"] = {
        {"summary", "Takes a scene of the client's, where uploads are allowed"},
        {"description",
         "The body is a .glb, a .gltf that holds its files, or an archive of one scene and its "
         "files. The id comes from the content. limits.uploadBytes of GET /v1/renderer is 0 where "
         "uploads are off (403). Prefer: respond-async answers at once."},
        {"parameters", ordered_json::array({{{"name", "title"},
                                             {"in", "query"},
                                             {"description", "what people call it"},
                                             {"schema", {{"type", "string"}}}}})},
        {"requestBody", {{"required", true}, {"content", std::move(content)}}},
        {"responses",
         {{"201", scene("the scene; its place is in Location")},
          {"200", scene("the same content was here before")},
          {"202", scene("it loads; GET its Location tells state, stage and progress")},
          {"422", problemAnswer("no scene came of it: `reason` is unsupported, malformed, "
                                "crashed, timedOut, memory or limit")},
          {"507", problemAnswer("no room for it")},
          {"default", problemAnswer("what went wrong")}}}};
    return path;
}

ordered_json scenePath() {
    ordered_json path = withPathParameters(
        getObject("One scene: what it holds and why each surface was classed so; its memory",
                  "Scene"),
        {"id"});
    path["delete"] = {{"summary", "Forgets a scene that was uploaded"},
                      {"parameters", pathParameters({"id"})},
                      {"responses",
                       {{"204", {{"description", "frames of it that run are finished"}}},
                        {"default", problemAnswer("what went wrong")}}}};
    return path;
}

ordered_json paths() {
    ordered_json query = frameQueryParameters();
    query.push_back(explainParameter());
    return {
        {"/v1/frames",
         {{"post",
           {{"summary", "Renders one frame"},
            {"parameters", ordered_json::array({explainParameter()})},
            {"requestBody", frameBody()},
            {"responses", frameAnswers()}}},
          {"get",
           {{"summary", "The same as a link"},
            {"description",
             "Names are paths joined by dots; a last part that only one field has may stand alone "
             "(yfov, target, refraction), and eye, camera, environment and accuracy are short for "
             "camera.position, camera.name, environment.map and accuracy.preset."},
            {"parameters", std::move(query)},
            {"responses", frameAnswers()}}}}},
        {"/v1/plans",
         {{"post",
           {{"summary", "What a frame would take, without drawing it"},
            {"requestBody", frameBody()},
            {"responses",
             answers("passes; what was left out and why; how each reflector and piece of glass "
                     "is served, out of which ways, and why; totals",
                     jsonContent(reference("Plan")))}}}}},
        {"/v1/comparisons",
         {{"post",
           {{"summary", "What accuracies cost and how far each is from the truth"},
            {"description",
             "A job: its result holds, for each setting, milliseconds, error over the frame and "
             "over each effect's own pixels against a path-traced picture, and how much of the gap "
             "it closes."},
            {"requestBody",
             {{"required", true}, {"content", jsonContent(reference("ComparisonRequest"))}}},
            {"responses",
             {{"202",
               {{"description", "the job, whose place is in Location"},
                {"content", jsonContent(reference("Job"))}}},
              {"default", problemAnswer("what went wrong, with every wrong field")}}}}}}},
        {"/v1/sequences",
         {{"post",
           {{"summary", "Many frames in one answer, sent as they are drawn"},
            {"description",
             "A tar, or with Accept: multipart/mixed the same files as parts: for each frame its "
             "pictures, then NNNNNN.json with the camera's matrices, plans and milliseconds; "
             "manifest.json stands last."},
            {"requestBody",
             {{"required", true}, {"content", jsonContent(reference("SequenceRequest"))}}},
            {"responses", answers("the files", {{kTarType, binaryContent()},
                                                {"multipart/mixed", binaryContent()}})}}}}},
        {"/v1/views/{name}",
         {{"put",
           {{"summary", "What a live view shows from now on"},
            {"parameters", pathParameters({"name"})},
            {"requestBody", frameBody()},
            {"responses",
             {{"204", {{"description", "whoever watches it sees this"}}},
              {"default", problemAnswer("what went wrong, with every wrong field")}}}}},
          {"get",
           {{"summary", "What a live view shows"},
            {"parameters", pathParameters({"name"})},
            {"responses", answers("a frame's body", jsonContent(reference("FrameRequest")))}}}}},
        {"/v1/stream",
         {{"get",
           {{"summary", "A view as motion JPEG, drawn anew when it changes"},
            {"description", "view names a live view; without it the query is a frame's link."},
            {"parameters", streamParameters()},
            {"responses", answers("parts of a picture each",
                                  {{"multipart/x-mixed-replace", binaryContent()}})}}}}},
        {"/v1/jobs/{id}",
         {{"get", jobOperation("How far a job is, and what came out")},
          {"delete", jobOperation("Cancels a job; what is done stays done")}}},
        {"/v1/jobs/{id}/pictures/{number}",
         withPathParameters(get("A picture that a job made",
                                answers("the picture", {{"image/png", binaryContent()}})),
                            {"id", "number"})},
        {"/v1/scenes", scenesPath()},
        {"/v1/scenes/{id}", scenePath()},
        {"/v1/renderer", getObject("What draws, as the driver says it; limits; build", "Renderer")},
        {"/healthz", getObject("The process is alive", "Status")},
        {"/readyz",
         getObject("A canary frame was drawn within the last seconds; the queue has room",
                   "Status")},
        {"/metrics", get("Prometheus text",
                         answers("metrics", {{"text/plain", {{"schema", {{"type", "string"}}}}}}))},
        {"/openapi.json",
         get("This document",
             answers("OpenAPI 3.1",
                     jsonContent({{"type", "object"}, {"additionalProperties", true}})))}};
}

// Names for generated clients, and what holds for every operation.
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
        operation["responses"]["4XX"] = problemAnswer("what was wrong with the request");
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
    return {{"openapi", "3.1.0"},
            {"info",
             {{"title", "Clerestory"},
              {"version", versionText()},
              {"description",
               "Camera poses in, rendered frames out. Metres, radians, seconds, linear colours; "
               "right-handed, +Y up, the camera looks down its own -Z."},
              {"license", {{"name", "MIT"}, {"identifier", "MIT"}}}}},
            {"servers", {{{"url", "/"}}}},
            // Asked for only where the server runs with --token-file.
            {"security", {{{"token", ordered_json::array()}}, ordered_json::object()}},
            {"paths", operations()},
            {"components",
             {{"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}},
              {"schemas", std::move(schemas)}}}};
}

}  // namespace clerestory
