#include "server/api/route_table.h"

#include "renderer.h"
#include "server/base/log.h"

#include <algorithm>

namespace clerestory {
namespace {

// The first part of `rest` up to a slash, which is taken off.
std::string_view nextPart(std::string_view& rest) {
    const std::size_t end = std::min(rest.find('/'), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return part;
}

}  // namespace

bool covers(std::string_view pattern, std::string_view path) {
    if (std::count(pattern.begin(), pattern.end(), '/') !=
        std::count(path.begin(), path.end(), '/')) {
        return false;
    }
    do {
        const std::string_view wanted = nextPart(pattern), part = nextPart(path);
        const bool any = !wanted.empty() && wanted.front() == '{';
        if (any ? part.empty() : part != wanted) return false;
    } while (!pattern.empty());
    return path.empty();
}

Answer otherMethod(const Call& call, const std::string& allow) {
    if (call.method == "OPTIONS") return {.status = 204, .headers = {{"Allow", allow}}};
    throw RequestError(methodNotAllowed(allow));
}

Answer problemAnswer(const Problem& problem, const std::string& requestId) {
    Answer answer{.status = problem.status,
                  .type = "application/problem+json",
                  .body = problemJson(problem, requestId),
                  .problem = problem.code};
    if (problem.retryAfterSeconds > 0) {
        answer.headers.emplace_back("Retry-After", std::to_string(problem.retryAfterSeconds));
    }
    if (problem.status == 401) answer.headers.emplace_back("WWW-Authenticate", "Bearer");
    if (!problem.allow.empty()) answer.headers.emplace_back("Allow", problem.allow);
    return answer;
}

Answer guarded(const Call& call, const std::function<Answer()>& handle) {
    try {
        return handle();
    } catch (const RequestError& error) {
        return problemAnswer(error.problem(), call.requestId);
    } catch (const InvalidRequest& error) {  // from the plan: a camera or map that is not there
        return problemAnswer(invalidFields(error.errors()), call.requestId);
    } catch (const RenderFailed& error) {
        logError({"request ", call.requestId, ": not drawn: ", error.what()});
        return problemAnswer(renderFailed(), call.requestId);
    } catch (const std::exception& error) {
        logError({"request ", call.requestId, ": ", error.what()});
        return problemAnswer(internalError(), call.requestId);
    }
}

}  // namespace clerestory
