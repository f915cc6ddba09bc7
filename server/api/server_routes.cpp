#include "server/api/server_routes.h"

#include "server/api/openapi.h"
#include "server/api/page.h"
#include "server/api/route_table.h"
#include "server/api/service_routes.h"
#include "server/api/uploads.h"
#include "server/base/log.h"
#include "server/live/live.h"
#include "server/live/sequences.h"
#include "server/server.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace clerestory {
namespace {

Answer health(Server&, const Call&) {
    return {.type = "application/json", .body = R"({"status":"alive"})"};
}

Answer metrics(Server& server, const Call& call) {
    std::string text = server.metrics().text(server.connections(), server.supervisor());
    try {
        const Answer drawn = server.ask(call);
        if (drawn.status == 200) text += drawn.body;
    } catch (const RequestError&) {
        // Nobody draws now; that is told in what stands already.
    }
    return {.type = kMetricsType, .body = text};
}

Answer openApi(Server&, const Call&) {
    return {.type = "application/json", .body = openApiDocument().dump()};
}

// Beside methods that are answered here.
Answer asked(Server& server, const Call& call) {
    return server.ask(call);
}

constexpr Route<Server> kServerRoutes[] = {
    {"/v1/scenes", "GET", asked},
    {"/v1/scenes", "POST", postScene},
    {"/v1/scenes/{id}", "GET", asked},
    {"/v1/scenes/{id}", "DELETE", deleteScene},
    {"/v1/sequences", "POST", postSequence},
    {"/v1/views/{name}", "PUT", putView},
    {"/v1/views/{name}", "GET", getView},
    {"/v1/stream", "GET", getStream},
    {"/healthz", "GET", health},
    {"/metrics", "GET", metrics},
    {"/openapi.json", "GET", openApi},
};

Answer anybodys(Server& server, const Call& call, std::string& route) {
    if (auto answer = routed<Server>(kServerRoutes, server, call, route)) return *std::move(answer);
    if (pageFile(call.path)) {
        route = "page";
        return call.method == "GET" ? *pageFile(call.path) : otherMethod(call, "GET, HEAD");
    }
    Answer answer = server.ask(call);
    route = answer.route;
    return answer;
}

// A log line is one line, whatever the client sent.
std::string plain(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
    return text;
}

Answer finished(Server& server, const Call& call, Answer answer, const std::string& route) {
    answer.route = route.empty() ? "other" : route;
    server.metrics().request(answer.route, answer.status);
    if (!answer.problem.empty()) server.metrics().refused(answer.problem);
    const bool chatter = answer.route == "/healthz" || answer.route == "/readyz" ||
                         answer.route == "/metrics" || answer.route == "page";
    const std::string line =
        call.method + " " + plain(call.path) + " " + std::to_string(answer.status) + " " +
        std::to_string(answer.body.size()) + " bytes " +
        fixedPoint(millisecondsSince(call.arrived), 1) + " ms " + call.requestId;
    chatter ? logDebug({line}) : logInfo({line});
    return answer;
}

}  // namespace

Answer answerTo(Server& server, const Call& call) {
    std::string route;
    Answer answer = guarded(call, [&] { return anybodys(server, call, route); });
    return finished(server, call, std::move(answer), route);
}

std::optional<Answer> quickAnswerTo(Server& server, const Call& call) {
    if (call.path == "/healthz") return answerTo(server, call);
    // A frame that the client has already costs no turn.
    if (!takesTurn(call) || !call.header("If-None-Match").empty()) return std::nullopt;
    const auto problem = server.refusalFor(call);
    return problem ? std::optional(answerWith(server, call, *problem)) : std::nullopt;
}

Answer answerWith(Server& server, const Call& call, const Problem& problem) {
    return finished(server, call, problemAnswer(problem, call.requestId), "");
}

bool isOpenPath(std::string_view path) {
    return path == "/healthz" || path == "/readyz" || pageFile(std::string(path));
}

bool isLinkedPath(std::string_view path) {
    return path == "/v1/frames";
}

std::vector<std::pair<std::string, std::string>> routePaths() {
    auto paths = serviceRoutePaths();
    for (const auto& row : kServerRoutes) {
        const std::pair<std::string, std::string> path(row.path, row.method);
        if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
    }
    return paths;
}

}  // namespace clerestory
