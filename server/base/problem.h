// A failure as the client sees it: a status and a problem document (RFC 9457). All messages are
// here; they never contain paths, exception texts or other internal details.
#pragma once

#include "plan/request/frame_request.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// Stable. Their names in the API and in the metrics are those of the enumerators.
enum class ProblemCode {
    notJson,
    badRequest,
    unauthorized,
    forbidden,
    notFound,
    methodNotAllowed,
    requestTimeout,
    stillLoading,
    stillMeasuring,
    lengthRequired,
    tooLarge,
    uriTooLong,
    unsupportedType,
    unsupportedEncoding,
    expectationFailed,
    misdirected,
    invalidFields,
    sceneFailed,
    mapFailed,
    headTooLarge,
    notImplemented,
    versionNotSupported,
    clientLeft,
    tooManyConnections,
    queueFull,
    jobsFull,
    streamsFull,
    bodiesFull,
    responsesFull,
    noWorker,
    renderFailed,
    quarantined,
    shuttingDown,
    notReady,
    stillCompiling,
    overDeadline,
    internalError,
    noRoom
};
inline constexpr std::size_t kProblemCodes = static_cast<std::size_t>(ProblemCode::noRoom) + 1;
std::string_view nameOf(ProblemCode code);

struct Problem {
    int status = 500;
    ProblemCode code = ProblemCode::internalError;  // also the end of `type` in the document
    std::string title;                              // the same for every problem with this code
    std::string detail;
    std::vector<FieldError> errors;
    int retryAfterSeconds = 0;  // 0: no Retry-After
    std::string allow;          // 405: the allowed methods
    std::string reason;         // why a scene or a map could not be loaded, camelCase
};

// Whether the same request may succeed later: something is busy, loading or being measured.
inline bool isTemporary(const Problem& problem) {
    return problem.retryAfterSeconds > 0;
}

// Thrown by the handler of a route; the router turns it into the response.
class RequestError : public std::runtime_error {
public:
    explicit RequestError(Problem problem)
        : std::runtime_error(problem.detail), problem_(std::move(problem)) {}
    const Problem& problem() const { return problem_; }

private:
    Problem problem_;
};

Problem notJson(std::string detail);                                 // 400
Problem badRequest(std::string detail);                              // 400: malformed HTTP
Problem notHttp();                                                   // 400
Problem unauthorized();                                              // 401
Problem forbidden(std::string detail);                               // 403
Problem notFound(std::string detail);                                // 404
Problem methodNotAllowed(std::string allow);                         // 405
Problem requestTimeout(const char* part, double seconds);            // 408
Problem stillLoading(std::string detail);                            // 409
Problem stillMeasuring(const std::string& job, double progress);     // 409
Problem lengthRequired();                                            // 411
Problem tooLarge(std::size_t maxBytes);                              // 413
Problem uriTooLong(std::size_t maxPath, std::size_t maxLine);        // 414
Problem notJsonType();                                               // 415
Problem encodedBody();                                               // 415
Problem notSceneType();                                              // 415
Problem notMapType();                                                // 415
Problem expectationFailed();                                         // 417
Problem misdirected();                                               // 421
Problem invalidFields(std::vector<FieldError> errors);               // 422
Problem quarantined();                                               // 422
Problem sceneFailed(std::string detail, std::string reason);         // 422
Problem mapFailed(std::string detail, std::string reason);           // 422
Problem headTooLarge(std::size_t maxBytes, std::size_t maxHeaders);  // 431
Problem notImplemented();                                            // 501
Problem versionNotSupported();                                       // 505
Problem clientLeft();                                                // 503
Problem tooManyConnections();                                        // 503
Problem streamsFull();                                               // 503
Problem bodiesFull();
Problem responsesFull();                         // 503
Problem queueFull(int retryAfterSeconds);        // 503
Problem jobsFull();                              // 503
Problem noWorker();                              // 503
Problem renderFailed();                          // 503
Problem shuttingDown();                          // 503
Problem notReady(std::string detail);            // 503
Problem stillCompiling(std::uint64_t programs);  // 503
Problem tooLongForDeadline(double neededSeconds, double leftSeconds);
// 503: a frame of a job took longer than this each time, while clients waited.
Problem tooLongForJob(double seconds);
Problem overDeadline(double seconds);  // 504
Problem internalError();               // 500
Problem noRoom(std::string detail);    // 507

// The problem document; problemJson() is its text.
nlohmann::ordered_json problemDocument(const Problem& problem, const std::string& requestId);
std::string problemJson(const Problem& problem, const std::string& requestId);

}  // namespace clerestory
