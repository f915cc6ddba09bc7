#include "server/base/problem.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

// With one digit behind the point.
std::string shortNumber(double value) {
    std::string text = std::to_string(value);
    text.resize(text.find('.') + 2);
    return text;
}

}  // namespace

Problem notJson(std::string detail) {
    return {.status = 400, .code = "notJson", .title = "Not JSON", .detail = std::move(detail)};
}

Problem badRequest(std::string detail) {
    return {
        .status = 400, .code = "badRequest", .title = "Bad request", .detail = std::move(detail)};
}

Problem notHttp() {
    return badRequest("This is not a request of HTTP/1.1.");
}

Problem unauthorized() {
    return {.status = 401,
            .code = "unauthorized",
            .title = "Unauthorized",
            .detail = "Send the server's token as Authorization: Bearer TOKEN."};
}

Problem forbidden(std::string detail) {
    return {.status = 403, .code = "forbidden", .title = "Forbidden", .detail = std::move(detail)};
}

Problem notFound(std::string detail) {
    return {.status = 404, .code = "notFound", .title = "Not found", .detail = std::move(detail)};
}

Problem methodNotAllowed(std::string allow) {
    std::string detail = "This path answers " + allow + ".";
    return {.status = 405,
            .code = "methodNotAllowed",
            .title = "Method not allowed",
            .detail = std::move(detail),
            .allow = std::move(allow)};
}

Problem requestTimeout(const char* part, double seconds) {
    return {.status = 408,
            .code = "requestTimeout",
            .title = "Request timeout",
            .detail = std::string("The ") + part + " of the request was not here within " +
                      shortNumber(seconds) + " seconds."};
}

Problem stillLoading(std::string detail) {
    return {.status = 409,
            .code = "stillLoading",
            .title = "Still loading",
            .detail = std::move(detail),
            .retryAfterSeconds = 1};
}

Problem stillMeasuring(const std::string& job, double progress) {
    return {.status = 409,
            .code = "stillMeasuring",
            .title = "Still measuring",
            .detail = "What accuracy costs in this scene is being measured, " +
                      std::to_string(static_cast<int>(100.0 * progress)) + " %: /v1/jobs/" + job +
                      ". Then the budget is kept without waiting.",
            .retryAfterSeconds = 2};
}

Problem lengthRequired() {
    return {.status = 411,
            .code = "lengthRequired",
            .title = "Length required",
            .detail = "Send the body with a Content-Length."};
}

Problem tooLarge(std::size_t maxBytes) {
    return {.status = 413,
            .code = "tooLarge",
            .title = "Too large",
            .detail = "A body may have " + std::to_string(maxBytes) + " bytes."};
}

Problem uriTooLong(std::size_t maxPath, std::size_t maxLine) {
    return {.status = 414,
            .code = "uriTooLong",
            .title = "URI too long",
            .detail = "A path may have " + std::to_string(maxPath) + " bytes and a request line " +
                      std::to_string(maxLine) + ". Long requests go into the body of a POST."};
}

Problem notJsonType() {
    return {.status = 415,
            .code = "unsupportedType",
            .title = "Unsupported media type",
            .detail = "Send the body as Content-Type: application/json."};
}

Problem encodedBody() {
    return {.status = 415,
            .code = "unsupportedEncoding",
            .title = "Unsupported content encoding",
            .detail = "Send the body without a Content-Encoding."};
}

Problem expectationFailed() {
    return {.status = 417,
            .code = "expectationFailed",
            .title = "Expectation failed",
            .detail = "The only expectation known is 100-continue."};
}

Problem misdirected() {
    return {.status = 421,
            .code = "misdirected",
            .title = "Misdirected request",
            .detail =
                "The server does not go by this name. Whoever runs it can allow one with "
                "--allow-host."};
}

Problem invalidFields(std::vector<FieldError> errors) {
    std::string detail;
    for (const FieldError& e : errors) {
        detail += (detail.empty() ? "" : "; ") + (e.pointer.empty() ? "the body" : e.pointer) +
                  " " + e.detail;
    }
    return {.status = 422,
            .code = "invalidFields",
            .title = "Invalid fields",
            .detail = detail + ".",
            .errors = std::move(errors)};
}

Problem notSceneType() {
    return {.status = 415,
            .code = "unsupportedType",
            .title = "Unsupported media type",
            .detail =
                "Send a .glb (model/gltf-binary), a .gltf that holds all its files "
                "(model/gltf+json), or a .zip, .tar or .tar.gz of a scene and its files "
                "(application/zip, application/x-tar, application/gzip); any of them as "
                "application/octet-stream. The content decides."};
}

Problem sceneFailed(std::string detail, std::string reason) {
    return {.status = 422,
            .code = "sceneFailed",
            .title = "The scene could not be loaded",
            .detail = std::move(detail),
            .errors = {{"/scene", "could not be loaded", "a scene whose state is ready"}},
            .reason = std::move(reason)};
}

Problem headTooLarge(std::size_t maxBytes, std::size_t maxHeaders) {
    return {.status = 431,
            .code = "headTooLarge",
            .title = "Request header fields too large",
            .detail = "The head of a request may have " + std::to_string(maxBytes) + " bytes and " +
                      std::to_string(maxHeaders) + " headers."};
}

Problem notImplemented() {
    return {.status = 501,
            .code = "notImplemented",
            .title = "Not implemented",
            .detail = "The server knows no such method."};
}

Problem versionNotSupported() {
    return {.status = 505,
            .code = "versionNotSupported",
            .title = "HTTP version not supported",
            .detail = "The server speaks HTTP/1.1."};
}

Problem clientLeft() {
    return {.status = 503,
            .code = "clientLeft",
            .title = "The client left",
            .detail = "The connection was closed on the client's side while the frame waited.",
            .retryAfterSeconds = 1};
}

Problem tooManyConnections() {
    return {.status = 503,
            .code = "tooManyConnections",
            .title = "Too many connections",
            .detail = "As many clients are being answered as may be. Ask again later.",
            .retryAfterSeconds = 1};
}

Problem queueFull(int retryAfterSeconds) {
    return {.status = 503,
            .code = "queueFull",
            .title = "Queue full",
            .detail = "As many frames wait as may wait. Ask again later.",
            .retryAfterSeconds = retryAfterSeconds};
}

Problem jobsFull() {
    return {.status = 503,
            .code = "jobsFull",
            .title = "Too many jobs",
            .detail = "As many long jobs wait as may wait. Ask again later, or cancel one.",
            .retryAfterSeconds = 10};
}

Problem streamsFull() {
    return {.status = 503,
            .code = "streamsFull",
            .title = "Too many streams",
            .detail = "As many sequences and live streams run as may run. Ask again later.",
            .retryAfterSeconds = 10};
}

Problem bodiesFull() {
    return {.status = 503,
            .code = "bodiesFull",
            .title = "Too many large bodies",
            .detail = "As many large bodies are on their way as may be. Send this one again later.",
            .retryAfterSeconds = 5};
}

Problem noWorker() {
    return {.status = 503,
            .code = "noWorker",
            .title = "No renderer",
            .detail = "The renderer ended and another one starts. Ask again later.",
            .retryAfterSeconds = 2};
}

Problem renderFailed() {
    return {.status = 503,
            .code = "renderFailed",
            .title = "Not drawn",
            .detail =
                "The graphics driver did not finish this frame, probably for want of memory. "
                "Others are drawn; a smaller one may be.",
            .retryAfterSeconds = 1};
}

Problem quarantined() {
    return {.status = 422,
            .code = "quarantined",
            .title = "Quarantined",
            .detail =
                "The renderer ended more than once while it worked on this very request, "
                "which is refused for ten minutes. Please report it."};
}

Problem shuttingDown() {
    return {.status = 503,
            .code = "shuttingDown",
            .title = "Shutting down",
            .detail = "The server finishes what runs and takes nothing new.",
            .retryAfterSeconds = 5};
}

Problem notReady(std::string detail) {
    return {.status = 503,
            .code = "notReady",
            .title = "Not ready",
            .detail = std::move(detail),
            .retryAfterSeconds = 1};
}

Problem stillCompiling(std::uint64_t programs) {
    return {.status = 503,
            .code = "stillCompiling",
            .title = "Still compiling",
            .detail = "The driver is compiling shaders for this frame or those before it; " +
                      std::to_string(programs) + " programs are done. Retry later.",
            .retryAfterSeconds = 2};
}

Problem overDeadline(double seconds) {
    return {.status = 504,
            .code = "overDeadline",
            .title = "Over the deadline",
            .detail = "The frame was not done within " + shortNumber(seconds) + " seconds."};
}

Problem internalError() {
    return {.status = 500,
            .code = "internalError",
            .title = "Internal error",
            .detail = "The server failed. Its log tells more under this request's id."};
}

Problem noRoom(std::string detail) {
    return {.status = 507,
            .code = "noRoom",
            .title = "Insufficient storage",
            .detail = std::move(detail)};
}

std::string problemJson(const Problem& problem, const std::string& requestId) {
    nlohmann::ordered_json json = {{"type", "urn:clerestory:problem:" + problem.code},
                                   {"code", problem.code},
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
    // Bytes of the client's that are not UTF-8 become replacement characters.
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace clerestory
