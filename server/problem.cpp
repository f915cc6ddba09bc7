#include "server/problem.h"

#include <nlohmann/json.hpp>

namespace clerestory {

Problem notJson(std::string detail) {
    return {.status = 400, .code = "notJson", .title = "Not JSON", .detail = std::move(detail)};
}

Problem badRequest(std::string detail) {
    return {
        .status = 400, .code = "badRequest", .title = "Bad request", .detail = std::move(detail)};
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

Problem uriTooLong(std::size_t maxBytes) {
    return {.status = 414,
            .code = "uriTooLong",
            .title = "URI too long",
            .detail = "A path may have " + std::to_string(maxBytes) +
                      " bytes. Long requests go into the body of a POST."};
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

Problem sceneFailed(std::string detail) {
    return {.status = 422,
            .code = "sceneFailed",
            .title = "The scene could not be loaded",
            .detail = std::move(detail),
            .errors = {{"/scene", "could not be loaded", "a scene whose state is ready"}}};
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

Problem overDeadline(double seconds) {
    std::string text = std::to_string(seconds);
    text.resize(text.find('.') + 2);
    return {.status = 504,
            .code = "overDeadline",
            .title = "Over the deadline",
            .detail = "The frame was not done within " + text + " seconds."};
}

Problem internalError() {
    return {.status = 500,
            .code = "internalError",
            .title = "Internal error",
            .detail = "The server failed. Its log tells more under this request's id."};
}

std::string problemJson(const Problem& problem, const std::string& requestId) {
    nlohmann::ordered_json json = {{"type", "urn:clerestory:problem:" + problem.code},
                                   {"title", problem.title},
                                   {"status", problem.status},
                                   {"detail", problem.detail},
                                   {"requestId", requestId}};
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
