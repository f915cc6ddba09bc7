#include "server/routes.h"

#include "server/build_id.h"
#include "server/comparisons.h"
#include "server/frames.h"
#include "server/job_routes.h"
#include "server/live.h"
#include "server/openapi.h"
#include "server/page.h"
#include "server/scene_json.h"
#include "server/sequences.h"
#include "server/service.h"

#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

Answer jsonAnswer(const ordered_json& json) {
    return {.type = "application/json",
            .body = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace)};
}

Answer listScenes(Service& service, const Call&) {
    ordered_json list = ordered_json::array();
    for (const SceneStatus& status : service.library().all()) {
        list.push_back(sceneSummary(status, status.id == service.library().defaultId()));
    }
    return jsonAnswer({{"scenes", std::move(list)}});
}

Answer describeScene(Service& service, const Call& call) {
    const std::string id = call.path.substr(call.path.rfind('/') + 1);
    const SceneStatus status = service.library().find(id);
    return jsonAnswer(sceneDetails(status, status.id == service.library().defaultId()));
}

Answer describeRenderer(Service& service, const Call&) {
    const RendererIdentity& id = service.queue().identity();
    const Config& config = service.config();
    return jsonAnswer({{"vendor", id.vendor},
                       {"renderer", id.renderer},
                       {"version", id.version},
                       {"shadingLanguage", id.shadingLanguage},
                       {"platform", id.platform},
                       {"software", id.software},
                       {"clipControl", id.clipControl},
                       {"timerQueriesTrusted", id.timerQueriesTrusted},
                       {"maxSamples", id.maxSamples},
                       {"maxAnisotropy", id.maxAnisotropy},
                       {"maxTextureSize", id.maxTextureSize},
                       {"environments", service.library().environmentNames()},
                       {"threads", std::thread::hardware_concurrency()},
                       {"limits",
                        {{"edge", kMaxEdge},
                         {"pixels", kMaxPixels},
                         {"bodyBytes", config.http.limits.bodyBytes},
                         {"queue", config.queue},
                         {"deadlineSeconds", config.deadlineSeconds}}},
                       {"program", {{"version", versionText()}, {"build", buildId()}}}});
}

Answer health(Service&, const Call&) {
    return jsonAnswer({{"status", "alive"}});
}

Answer readiness(Service& service, const Call&) {
    if (!service.queue().hasRoom()) throw RequestError(notReady("The queue is full."));
    const SceneState first = service.library().find(service.library().defaultId()).state;
    if (first != SceneState::ready) {
        throw RequestError(notReady("The default scene is " + std::string(nameOf(first)) + "."));
    }
    service.checkCanary();
    return jsonAnswer({{"status", "ready"}});
}

Answer metrics(Service& service, const Call&) {
    return {.type = "text/plain; version=0.0.4; charset=utf-8",
            .body = service.metrics().text(service.queue().depth(), service.connections())};
}

Answer openApi(Service&, const Call&) {
    return jsonAnswer(openApiDocument());
}

struct Route {
    const char* path;  // "{id}" stands for any part
    const char* method;
    Answer (*answer)(Service&, const Call&);
};

constexpr Route kRoutes[] = {
    {"/v1/frames", "POST", postFrame},
    {"/v1/frames", "GET", getFrame},
    {"/v1/plans", "POST", postPlan},
    {"/v1/comparisons", "POST", postComparison},
    {"/v1/sequences", "POST", postSequence},
    {"/v1/views/{name}", "PUT", putView},
    {"/v1/views/{name}", "GET", getView},
    {"/v1/stream", "GET", getStream},
    {"/v1/jobs/{id}", "GET", getJob},
    {"/v1/jobs/{id}", "DELETE", cancelJob},
    {"/v1/jobs/{id}/pictures/{number}", "GET", getJobPicture},
    {"/v1/scenes", "GET", listScenes},
    {"/v1/scenes/{id}", "GET", describeScene},
    {"/v1/renderer", "GET", describeRenderer},
    {"/healthz", "GET", health},
    {"/readyz", "GET", readiness},
    {"/metrics", "GET", metrics},
    {"/openapi.json", "GET", openApi},
};

// The first part of `rest` up to a slash, which is taken off.
std::string_view nextPart(std::string_view& rest) {
    const std::size_t end = std::min(rest.find('/'), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return part;
}

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

Answer routed(Service& service, const Call& call, std::string& route) {
    std::string allow;
    for (const Route& row : kRoutes) {
        if (!covers(row.path, call.path)) continue;
        route = row.path;
        if (call.method == row.method) return row.answer(service, call);
        allow += (allow.empty() ? "" : ", ") + std::string(row.method);
        if (row.method == std::string_view("GET")) allow += ", HEAD";
    }
    if (allow.empty() && pageFile(call.path)) {
        route = "page";
        if (call.method == "GET") return *pageFile(call.path);
        allow = "GET, HEAD";
    }
    if (allow.empty()) throw RequestError(notFound("There is nothing at this path."));
    if (call.method == "OPTIONS") return {.status = 204, .headers = {{"Allow", allow}}};
    throw RequestError(methodNotAllowed(allow));
}

Answer problemAnswer(const Problem& problem, const std::string& requestId) {
    Answer answer{.status = problem.status,
                  .type = "application/problem+json",
                  .body = problemJson(problem, requestId)};
    if (problem.retryAfterSeconds > 0) {
        answer.headers.emplace_back("Retry-After", std::to_string(problem.retryAfterSeconds));
    }
    if (problem.status == 401) answer.headers.emplace_back("WWW-Authenticate", "Bearer");
    if (!problem.allow.empty()) answer.headers.emplace_back("Allow", problem.allow);
    return answer;
}

// A log line is one line, whatever the client sent.
std::string plain(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
    return text;
}

Answer finished(Service& service, const Call& call, Answer answer, const std::string& route) {
    answer.route = route.empty() ? "other" : route;
    service.metrics().request(answer.route, answer.status);
    const bool chatter = answer.route == "/healthz" || answer.route == "/readyz" ||
                         answer.route == "/metrics" || answer.route == "page";
    spdlog::log(chatter ? spdlog::level::debug : spdlog::level::info,
                "{} {} {} {} bytes {:.1f} ms {}", call.method, plain(call.path), answer.status,
                answer.body.size(), millisecondsSince(call.arrived), call.requestId);
    return answer;
}

Answer refused(Service& service, const Call& call, const Problem& problem,
               const std::string& route) {
    service.metrics().refused(problem.code);
    return finished(service, call, problemAnswer(problem, call.requestId), route);
}

}  // namespace

Answer answerTo(Service& service, const Call& call) {
    std::string route;
    try {
        return finished(service, call, routed(service, call, route), route);
    } catch (const RequestError& error) {
        return refused(service, call, error.problem(), route);
    } catch (const InvalidRequest& error) {  // from the plan: a camera or map that is not there
        return refused(service, call, invalidFields(error.errors()), route);
    } catch (const std::exception& error) {
        spdlog::error("request {}: {}", call.requestId, error.what());
        return refused(service, call, internalError(), route);
    }
}

bool isOpenPath(std::string_view path) {
    return path == "/healthz" || path == "/readyz" || pageFile(std::string(path));
}

bool isLinkedPath(std::string_view path) {
    return path == "/v1/frames";
}

std::optional<Answer> quickAnswerTo(Service& service, const Call& call) {
    if (call.path == "/healthz") return answerTo(service, call);
    const bool draws = call.path == "/v1/frames" || call.path == "/v1/plans";
    // A frame that the client has already costs no turn.
    if (!draws || !call.header("If-None-Match").empty()) return std::nullopt;
    const auto problem = service.queue().refusalFor(call.client);
    return problem ? std::optional(answerWith(service, call, *problem)) : std::nullopt;
}

Answer answerWith(Service& service, const Call& call, const Problem& problem) {
    return refused(service, call, problem, "");
}

std::vector<std::pair<std::string, std::string>> routePaths() {
    std::vector<std::pair<std::string, std::string>> paths;
    for (const Route& row : kRoutes) paths.emplace_back(row.path, row.method);
    return paths;
}

}  // namespace clerestory
