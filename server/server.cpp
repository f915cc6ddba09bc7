#include "server/server.h"

#include "scene/hash.h"
#include "server/api/frames.h"
#include "server/api/openapi.h"
#include "server/api/page.h"
#include "server/api/uploads.h"
#include "server/backend/local_backend.h"
#include "server/base/log.h"
#include "server/live/live_routes.h"
#include "server/worker/worker_backend.h"

#include <algorithm>

namespace clerestory {
namespace {

// Every waiting frame, stream and wait for light occupies a thread; other requests must not wait
// for them.
HttpServerOptions httpServerOptions(const Config& config) {
    HttpServerOptions options = config.http;
    options.threads += config.queue + options.limits.streams + options.limits.waits;
    options.limits.large.push_back({"POST", "/v1/sequences", config.sequenceBytes});
    const UploadOptions& uploads = config.scenes.uploads;
    if (!uploads.folder.empty()) {
        options.limits.large.push_back({"POST", "/v1/scenes", uploads.limits.fileBytes});
        options.limits.large.push_back({"POST", "/v1/environments", uploads.limits.fileBytes});
        options.limits.largeBytes = std::max(options.limits.largeBytes, uploads.limits.fileBytes);
    }
    return options;
}

// Paths that need no token.
bool isOpenPath(std::string_view path) {
    return path == "/healthz" || path == "/readyz" || pageFile(std::string(path));
}

// Paths whose GET a signed link permits.
bool isLinkedPath(std::string_view path) {
    return path == "/v1/frames";
}

std::unique_ptr<RenderBackend> makeBackend(const Config& config) {
    if (config.singleProcess) return std::make_unique<LocalBackend>(localBackendOptions(config));
    return std::make_unique<WorkerBackend>(workerBackendOptions(config));
}

// A line of the log is one line, whatever the client sent.
std::string printable(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
    return text;
}

struct DocumentRoutes {};

Answer getHealth(const DocumentRoutes&, const Call&) {
    return {.type = "application/json", .body = R"({"status":"alive"})"};
}

// A document that changes with the program only: 304 if the client has it.
Answer documentAnswer(const Call& call, Answer document) {
    const std::string etag = '"' + hashWordOf(document.body) + '"';
    if (matchesEntityTag(call.header("If-None-Match"), etag)) {
        document = {.status = 304};
    }
    document.headers.emplace_back("Cache-Control", "no-cache");
    document.headers.emplace_back("ETag", etag);
    return document;
}

Answer getOpenApi(const DocumentRoutes&, const Call& call) {
    return documentAnswer(call, {.type = "application/json", .body = openApiText()});
}

struct MetricsRoutes {
    const RequestMetrics& metrics;
    HttpServer& http;
    RenderBackend& backend;
    FrameCache& cache;
};

// The metrics of the renderer are missing while there is none.
Answer getMetrics(const MetricsRoutes& routes, const Call& call) {
    std::string text = routes.metrics.text(routes.http.counters(), routes.http.holdings(),
                                           routes.cache.counters(), routes.backend.workerStatus());
    try {
        const Answer drawn = routes.backend.answer(call);
        if (!drawn.problem) text += drawn.body;
    } catch (const RequestError&) {
    }
    return {.type = kMetricsType, .body = text};
}

// For paths that also have methods which are answered here.
struct ForwardedRoutes {
    RenderBackend& backend;
};

Answer forward(const ForwardedRoutes& routes, const Call& call) {
    return routes.backend.answer(call);
}

}  // namespace

Server::Server(const Config& config)
    : http_(httpServerOptions(config),
            {.quick = [this](const Call& call,
                             std::string_view body) { return quickAnswer(call, body); },
             .respond = [this](const Call& call) { return answer(call); },
             .refuse = [this](const Call& call,
                              const Problem& problem) { return refuse(call, problem); },
             .paths = {.open = isOpenPath, .linked = isLinkedPath}}),
      streams_(http_.holdings()),
      views_(http_.holdings()) {
    const UploadOptions& uploads = config.scenes.uploads;
    if (!uploads.folder.empty()) uploads_.emplace(uploads.folder, uploads.limits);
    backend_ = makeBackend(config);
    cache_.emplace(*backend_,
                   FrameCache::Options{.maxBytes = config.frameCacheBytes,
                                       .signedLinks = !config.http.access.linkKeyFile.empty(),
                                       .uploads = uploads_ ? &*uploads_ : nullptr});
    frames_.emplace(*backend_, metrics_, stopping_,
                    config.singleProcess ? 1 : config.workers.renderers);

    const ForwardedRoutes forwarded{*backend_};
    routes_.add("/v1/scenes", "GET", forwarded, forward);
    routes_.add("/v1/scenes/{id}", "GET", forwarded, forward);
    routes_.add("/v1/environments", "GET", forwarded, forward);
    routes_.add("/v1/environments/{map}", "GET", forwarded, forward);
    addRoutes(routes_, UploadRoutes{*backend_, uploads_ ? &*uploads_ : nullptr,
                                    uploads.import.wallClock, stopping_, http_.holdings()});
    addRoutes(routes_, LiveRoutes{*frames_, views_, streams_});
    routes_.add("/healthz", "GET", DocumentRoutes{}, getHealth);
    routes_.add("/openapi.json", "GET", DocumentRoutes{}, getOpenApi);
    routes_.add("/metrics", "GET", MetricsRoutes{metrics_, http_, *backend_, *cache_}, getMetrics);
}

Server::~Server() {
    stop();
}

void Server::start() {
    listener_ = std::thread([this] { http_.serve(); });
}

void Server::stop() {
    if (!listener_.joinable()) return;
    stopping_ = true;
    cache_->stop();
    backend_->stop();
    http_.stop();
    listener_.join();
}

// Waiting for light occupies a thread, so that few calls may do so at once. The others are answered
// with what is computed: a server may ignore a preference (RFC 7240, 2).
Answer Server::answerWaiting(const Call& call) {
    const auto share = http_.holdings().take(Pool::waits, call.client, 1);
    if (share) return cache_->answer(call);
    Call now = call;
    now.header = [&call](const char* name) {
        return std::string_view(name) == "Prefer" ? std::string() : call.header(name);
    };
    return cache_->answer(now);
}

Answer Server::answerFrom(const Call& call, std::string& route) {
    if (auto answer = routes_.answer(call, route)) return *std::move(answer);
    if (auto file = pageFile(call.path)) {
        route = "page";
        return call.method == "GET" ? documentAnswer(call, *std::move(file))
                                    : otherMethod(call, "GET, HEAD");
    }
    const bool waits = call.path == "/v1/frames" && !call.header("Prefer").empty();
    Answer answer = waits ? answerWaiting(call) : cache_->answer(call);
    route = answer.route;
    return answer;
}

// On any thread of the front. Does not throw.
Answer Server::answer(const Call& call) {
    std::string route;
    Answer answer = guarded(call, [&] { return answerFrom(call, route); });
    return finish(call, std::move(answer), route);
}

// On the thread that serves every connection: does not block. Empty for what may take longer.
std::optional<Answer> Server::quickAnswer(const Call& call, std::string_view body) {
    if (call.path == "/healthz") return answer(call);
    // With an entity tag the answer may need no place in the queue.
    if (!needsRenderQueue(call) || !call.header("If-None-Match").empty()) return std::nullopt;
    const auto problem = backend_->refusalFor(call.client);
    if (!problem || cache_->mayHold(call, body)) return std::nullopt;
    return refuse(call, *problem);
}

Answer Server::refuse(const Call& call, const Problem& problem) {
    // A method that the path does not have is refused for that, with or without a body.
    const bool lacksLength = problem.code == ProblemCode::lengthRequired;
    const std::string allow = lacksLength ? methodsOf(call.path) : "";
    const bool unknown = !allow.empty() && allow.find(call.method) == std::string::npos;
    return finish(call, problemAnswer(unknown ? methodNotAllowed(allow) : problem, call.requestId),
                  "");
}

Answer Server::finish(const Call& call, Answer answer, const std::string& route) {
    answer.route = route.empty() ? "other" : route;
    if (answer.worker != 0) {
        answer.headers.emplace_back("Clerestory-Worker", std::to_string(answer.worker));
    }
    metrics_.request(answer.route, answer.status);
    if (answer.problem) metrics_.refused(answer.problem->code);
    const bool frequent = answer.route == "/healthz" || answer.route == "/readyz" ||
                          answer.route == "/metrics" || answer.route == "page";
    const std::string line =
        call.method + " " + printable(call.path) + " " + std::to_string(answer.status) + " " +
        std::to_string(answer.content().size()) + " bytes " +
        fixedPoint(millisecondsSince(call.arrived), 1) + " ms " + call.requestId;
    frequent ? logDebug({line}) : logInfo({line});
    return answer;
}

}  // namespace clerestory
