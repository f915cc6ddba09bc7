#include "server/base/problem.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>

namespace clerestory {
namespace {

// "5 s", "0.5 s"
std::string secondsText(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g s", seconds);
    return text;
}

// In the order of the enumeration.
constexpr std::array<std::string_view, kProblemCodes> kCodeNames{
    "notJson",           "badRequest",
    "unauthorized",      "forbidden",
    "notFound",          "methodNotAllowed",
    "requestTimeout",    "stillLoading",
    "stillMeasuring",    "lengthRequired",
    "tooLarge",          "uriTooLong",
    "unsupportedType",   "unsupportedEncoding",
    "expectationFailed", "misdirected",
    "invalidFields",     "sceneFailed",
    "mapFailed",         "headTooLarge",
    "notImplemented",    "versionNotSupported",
    "clientLeft",        "tooManyConnections",
    "queueFull",         "jobsFull",
    "streamsFull",       "bodiesFull",
    "responsesFull",     "noWorker",
    "renderFailed",      "quarantined",
    "shuttingDown",      "notReady",
    "stillCompiling",    "overDeadline",
    "internalError",     "noRoom"};

}  // namespace

std::string_view nameOf(ProblemCode code) {
    return kCodeNames.at(static_cast<std::size_t>(code));
}

Problem notJson(std::string detail) {
    return {.status = 400,
            .code = ProblemCode::notJson,
            .title = "Not JSON",
            .detail = std::move(detail)};
}

Problem badRequest(std::string detail) {
    return {.status = 400,
            .code = ProblemCode::badRequest,
            .title = "Bad request",
            .detail = std::move(detail)};
}

Problem notHttp() {
    return badRequest("The request is not valid HTTP/1.1.");
}

Problem unauthorized() {
    return {.status = 401,
            .code = ProblemCode::unauthorized,
            .title = "Unauthorized",
            .detail = "A valid token is required: Authorization: Bearer TOKEN."};
}

Problem forbidden(std::string detail) {
    return {.status = 403,
            .code = ProblemCode::forbidden,
            .title = "Forbidden",
            .detail = std::move(detail)};
}

Problem notFound(std::string detail) {
    return {.status = 404,
            .code = ProblemCode::notFound,
            .title = "Not found",
            .detail = std::move(detail)};
}

Problem methodNotAllowed(std::string allow) {
    std::string detail = "Methods allowed for this path: " + allow + ".";
    return {.status = 405,
            .code = ProblemCode::methodNotAllowed,
            .title = "Method not allowed",
            .detail = std::move(detail),
            .allow = std::move(allow)};
}

Problem requestTimeout(const char* part, double seconds) {
    return {.status = 408,
            .code = ProblemCode::requestTimeout,
            .title = "Request timeout",
            .detail = std::string("The ") + part + " of the request was not received within " +
                      secondsText(seconds) + "."};
}

Problem stillLoading(std::string detail) {
    return {.status = 409,
            .code = ProblemCode::stillLoading,
            .title = "Still loading",
            .detail = std::move(detail),
            .retryAfterSeconds = 1};
}

Problem stillMeasuring(const std::string& job, double progress) {
    return {.status = 409,
            .code = ProblemCode::stillMeasuring,
            .title = "Still measuring",
            .detail =
                "The cost of each accuracy in this scene is being measured, which the "
                "budget requires: " +
                std::to_string(static_cast<int>(100.0 * progress)) + " % done, see /v1/jobs/" +
                job + ".",
            .retryAfterSeconds = 2};
}

Problem lengthRequired() {
    return {.status = 411,
            .code = ProblemCode::lengthRequired,
            .title = "Length required",
            .detail = "A request with a body requires a Content-Length."};
}

Problem tooLarge(std::size_t maxBytes) {
    return {.status = 413,
            .code = ProblemCode::tooLarge,
            .title = "Request body too large",
            .detail = "Request body exceeds " + std::to_string(maxBytes) + " bytes."};
}

Problem uriTooLong(std::size_t maxPath, std::size_t maxLine) {
    return {.status = 414,
            .code = ProblemCode::uriTooLong,
            .title = "URI too long",
            .detail = "The path exceeds " + std::to_string(maxPath) +
                      " bytes or the request line exceeds " + std::to_string(maxLine) +
                      " bytes. Send a long request as the body of a POST."};
}

Problem notJsonType() {
    return {.status = 415,
            .code = ProblemCode::unsupportedType,
            .title = "Unsupported media type",
            .detail = "The Content-Type of the body must be application/json."};
}

Problem encodedBody() {
    return {.status = 415,
            .code = ProblemCode::unsupportedEncoding,
            .title = "Unsupported content encoding",
            .detail = "Content-Encoding of request bodies is not supported."};
}

Problem expectationFailed() {
    return {.status = 417,
            .code = ProblemCode::expectationFailed,
            .title = "Expectation failed",
            .detail = "The only supported expectation is 100-continue."};
}

Problem misdirected() {
    return {.status = 421,
            .code = ProblemCode::misdirected,
            .title = "Misdirected request",
            .detail = "Host not allowed. The operator can allow it with --allow-host."};
}

Problem invalidFields(std::vector<FieldError> errors) {
    constexpr std::size_t kInDetail = 16;
    errors.resize(std::min(errors.size(), kMaxFieldErrors));
    std::string detail;
    for (const FieldError& e : std::span(errors).first(std::min(errors.size(), kInDetail))) {
        detail += (detail.empty() ? "" : "; ") + (e.pointer.empty() ? "the body" : e.pointer) +
                  " " + e.detail;
    }
    return {.status = 422,
            .code = ProblemCode::invalidFields,
            .title = "Invalid fields",
            .detail = detail + (errors.size() > kInDetail ? "; and others." : "."),
            .errors = std::move(errors)};
}

Problem notSceneType() {
    return {.status = 415,
            .code = ProblemCode::unsupportedType,
            .title = "Unsupported media type",
            .detail =
                "Supported are .glb (model/gltf-binary), .gltf with embedded files "
                "(model/gltf+json), .stl (model/stl), .dae (model/vnd.collada+xml), .fbx, .ply and "
                ".3ds (application/octet-stream), and .zip, .tar or .tar.gz archives of one scene "
                "and its files (application/zip, application/x-tar, application/gzip), each also "
                "as application/octet-stream. The format is detected from the content; a .obj has "
                "no mark and must be in an archive."};
}

Problem sceneFailed(std::string detail, std::string reason) {
    return {.status = 422,
            .code = ProblemCode::sceneFailed,
            .title = "Scene could not be loaded",
            .detail = std::move(detail),
            .errors = {{"/scene", "could not be loaded", "a scene whose state is ready"}},
            .reason = std::move(reason)};
}

Problem notMapType() {
    return {.status = 415,
            .code = ProblemCode::unsupportedType,
            .title = "Unsupported media type",
            .detail =
                "Supported are .hdr (image/vnd.radiance), .exr (image/x-exr), .ktx (image/ktx), "
                ".ktx2 (image/ktx2) and .dds (image/vnd-ms.dds), each also as "
                "application/octet-stream. The format is detected from the content. An .hdr or "
                ".exr is equirectangular, the others are cube maps."};
}

Problem mapFailed(std::string detail, std::string reason) {
    return {.status = 422,
            .code = ProblemCode::mapFailed,
            .title = "Environment map could not be loaded",
            .detail = std::move(detail),
            .reason = std::move(reason)};
}

Problem headTooLarge(std::size_t maxBytes, std::size_t maxHeaders) {
    return {.status = 431,
            .code = ProblemCode::headTooLarge,
            .title = "Request header fields too large",
            .detail = "The request line and headers exceed " + std::to_string(maxBytes) +
                      " bytes or " + std::to_string(maxHeaders) + " fields."};
}

Problem notImplemented() {
    return {.status = 501,
            .code = ProblemCode::notImplemented,
            .title = "Not implemented",
            .detail = "This method is not supported."};
}

Problem versionNotSupported() {
    return {.status = 505,
            .code = ProblemCode::versionNotSupported,
            .title = "HTTP version not supported",
            .detail = "The supported version is HTTP/1.1."};
}

Problem clientLeft() {
    return {.status = 503,
            .code = ProblemCode::clientLeft,
            .title = "Client disconnected",
            .detail = "The client closed the connection before the frame was drawn.",
            .retryAfterSeconds = 1};
}

Problem tooManyConnections() {
    return {.status = 503,
            .code = ProblemCode::tooManyConnections,
            .title = "Too many connections",
            .detail = "The limit of concurrent connections is reached; retry later.",
            .retryAfterSeconds = 1};
}

Problem queueFull(int retryAfterSeconds) {
    return {.status = 503,
            .code = ProblemCode::queueFull,
            .title = "Render queue full",
            .detail = "Render queue is full; retry later.",
            .retryAfterSeconds = retryAfterSeconds};
}

Problem jobsFull() {
    return {.status = 503,
            .code = ProblemCode::jobsFull,
            .title = "Too many jobs",
            .detail = "Job queue is full; retry later or cancel a job.",
            .retryAfterSeconds = 10};
}

Problem streamsFull() {
    return {.status = 503,
            .code = ProblemCode::streamsFull,
            .title = "Too many streams",
            .detail = "The limit of concurrent sequences and live streams is reached; retry later.",
            .retryAfterSeconds = 10};
}

Problem bodiesFull() {
    return {.status = 503,
            .code = ProblemCode::bodiesFull,
            .title = "Too many large request bodies",
            .detail = "The limit of large request bodies in transfer is reached; retry later.",
            .retryAfterSeconds = 5};
}

Problem responsesFull() {
    return {.status = 503,
            .code = ProblemCode::responsesFull,
            .title = "Too many unread responses",
            .detail = "Responses that were sent to this client are not read yet; read them first.",
            .retryAfterSeconds = 2};
}

Problem noWorker() {
    return {.status = 503,
            .code = ProblemCode::noWorker,
            .title = "Renderer restarting",
            .detail = "The renderer process ended and a new one is starting; retry later.",
            .retryAfterSeconds = 2};
}

Problem renderFailed() {
    return {.status = 503,
            .code = ProblemCode::renderFailed,
            .title = "Rendering failed",
            .detail =
                "The graphics driver could not render this frame, probably because memory ran out. "
                "Other frames are not affected; a smaller one may succeed.",
            .retryAfterSeconds = 1};
}

Problem quarantined() {
    return {.status = 422,
            .code = ProblemCode::quarantined,
            .title = "Request quarantined",
            .detail =
                "The renderer process ended more than once while it handled this request, so the "
                "request is rejected for ten minutes. Please report it."};
}

Problem shuttingDown() {
    return {.status = 503,
            .code = ProblemCode::shuttingDown,
            .title = "Shutting down",
            .detail = "The server finishes running requests and accepts no new ones.",
            .retryAfterSeconds = 5};
}

Problem notReady(std::string detail) {
    return {.status = 503,
            .code = ProblemCode::notReady,
            .title = "Not ready",
            .detail = std::move(detail),
            .retryAfterSeconds = 1};
}

Problem stillCompiling(std::uint64_t programs) {
    return {.status = 503,
            .code = ProblemCode::stillCompiling,
            .title = "Compiling shaders",
            .detail = "The driver is compiling shaders for this frame or for earlier ones; " +
                      std::to_string(programs) + " programs are compiled. Retry later.",
            .retryAfterSeconds = 2};
}

Problem overDeadline(double seconds) {
    return {.status = 504,
            .code = ProblemCode::overDeadline,
            .title = "Deadline exceeded",
            .detail = "The frame was not rendered within " + secondsText(seconds) + "."};
}

Problem tooLongForDeadline(double neededSeconds, double leftSeconds) {
    return {
        .status = 504,
        .code = ProblemCode::overDeadline,
        .title = "Deadline exceeded",
        .detail = "The frame would take at least " + secondsText(neededSeconds) + ", and " +
                  secondsText(leftSeconds) +
                  " are left. Nothing was drawn. Reduce the size, the samples or the accuracy."};
}

Problem tooLongForJob(double seconds) {
    return {.status = 503,
            .code = ProblemCode::overDeadline,
            .title = "Frames of the job take too long",
            .detail = "A frame took longer than " + secondsText(seconds) +
                      " several times while other clients waited. Reduce the size or the accuracy, "
                      "or retry when the server is idle."};
}

Problem internalError() {
    return {.status = 500,
            .code = ProblemCode::internalError,
            .title = "Internal error",
            .detail = "Internal server error. The server log has details under this request id."};
}

Problem noRoom(std::string detail) {
    return {.status = 507,
            .code = ProblemCode::noRoom,
            .title = "Insufficient storage",
            .detail = std::move(detail)};
}

nlohmann::ordered_json problemDocument(const Problem& problem, const std::string& requestId) {
    const std::string code(nameOf(problem.code));
    nlohmann::ordered_json json = {{"type", "urn:clerestory:problem:" + code},
                                   {"code", code},
                                   {"title", problem.title},
                                   {"status", problem.status},
                                   {"detail", problem.detail},
                                   {"requestId", requestId}};
    if (!problem.reason.empty()) json["reason"] = problem.reason;
    if (!problem.errors.empty()) {
        auto& list = json["errors"] = nlohmann::ordered_json::array();
        for (const FieldError& e : problem.errors) {
            list.push_back({{"pointer", e.pointer}, {"detail", e.detail}, {"allowed", e.allowed}});
        }
    }
    return json;
}

std::string problemJson(const Problem& problem, const std::string& requestId) {
    const nlohmann::ordered_json json = problemDocument(problem, requestId);
    // Text from the client may not be UTF-8: invalid bytes become replacement characters.
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace clerestory
