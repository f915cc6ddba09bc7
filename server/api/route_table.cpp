#include "server/api/route_table.h"

#include "renderer.h"
#include "server/base/log.h"

#include <algorithm>

namespace clerestory {
namespace {

// Removes the first part of `rest` up to a slash, with the slash, and returns the part.
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

std::optional<Answer> Routes::answer(const Call& call, std::string& route) const {
    std::string allow;
    for (const Row& row : rows_) {
        if (!covers(row.path, call.path)) continue;
        route = row.path;
        if (call.method == row.method) return row.handler(call);
        allow += (allow.empty() ? "" : ", ") + std::string(row.method);
        if (row.method == std::string_view("GET")) allow += ", HEAD";
    }
    if (allow.empty()) return std::nullopt;
    return otherMethod(call, allow);
}

std::vector<std::pair<std::string, std::string>> Routes::paths() const {
    std::vector<std::pair<std::string, std::string>> list;
    for (const Row& row : rows_) list.emplace_back(row.path, row.method);
    return list;
}

Answer otherMethod(const Call& call, const std::string& allow) {
    if (call.method == "OPTIONS") return {.status = 204, .headers = {{"Allow", allow}}};
    throw RequestError(methodNotAllowed(allow));
}

Answer problemAnswer(const Problem& problem, const std::string& requestId) {
    Answer answer{.status = problem.status,
                  .type = "application/problem+json",
                  .body = problemJson(problem, requestId),
                  .problem = problem};
    if (problem.retryAfterSeconds > 0) {
        answer.headers.emplace_back("Retry-After", std::to_string(problem.retryAfterSeconds));
    }
    if (problem.status == 401) answer.headers.emplace_back("WWW-Authenticate", "Bearer");
    if (!problem.allow.empty()) answer.headers.emplace_back("Allow", problem.allow);
    return answer;
}

Problem currentProblem(const std::string& requestId) {
    try {
        throw;
    } catch (const RequestError& error) {
        return error.problem();
    } catch (const InvalidRequest& error) {  // by the planner: no such camera or map, and the like
        return invalidFields(error.errors());
    } catch (const RenderFailed& error) {
        logError({"request ", requestId, ": not drawn: ", error.what()});
        return renderFailed();
    } catch (const std::exception& error) {
        logError({"request ", requestId, ": ", error.what()});
        return internalError();
    }
}

Answer guarded(const Call& call, const std::function<Answer()>& handle) {
    try {
        return handle();
    } catch (const std::exception&) {
        return problemAnswer(currentProblem(call.requestId), call.requestId);
    }
}

}  // namespace clerestory
