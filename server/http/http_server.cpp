#include "server/http/http_server.h"

#include "server/http/cross_origin.h"
#include "server/http/event_loop.h"

#include <sys/resource.h>

#include <algorithm>

namespace clerestory {
namespace {

// File descriptors that are reserved for scenes, importers and the driver.
constexpr std::size_t kReservedDescriptors = 64;

// Raises the limit of file descriptors as far as allowed, and lowers that of connections to it.
HttpLimits withinDescriptors(HttpLimits limits) {
    rlimit files{};
    if (getrlimit(RLIMIT_NOFILE, &files) != 0) return limits;
    const rlim_t needed = limits.connections + kReservedDescriptors;
    if (files.rlim_cur < needed) {
        files.rlim_cur = std::min(needed, files.rlim_max);
        setrlimit(RLIMIT_NOFILE, &files);
    }
    const auto descriptors = static_cast<std::size_t>(files.rlim_cur);
    const std::size_t available =
        std::max(descriptors, 2 * kReservedDescriptors) - kReservedDescriptors;
    limits.connections = std::min(limits.connections, available);
    return limits;
}

}  // namespace

class HttpServer::Parts {
public:
    Parts(const HttpServerOptions& options, Routes given)
        : crossOrigin(options.access.origins),
          routes(permitted(std::move(given))),
          access(options.access, routes.paths),
          limits(withinDescriptors(options.limits)),
          listener(options.host, options.port),
          port(listener.port()),
          adapter(limits, routes.respond, routes.refuse),
          holdings({{Pool::requestBytes, {.most = limits.largeBytes}},
                    {Pool::responseBytes, {.most = limits.unsentBytes, .firstMayExceed = true}},
                    {Pool::smallResponseBytes,
                     {.most = limits.smallUnsentBytes, .firstMayExceed = true}},
                    {Pool::streams, {.most = limits.streams}},
                    {Pool::views, {.most = limits.views}},
                    {Pool::waits, {.most = limits.waits}}}),
          loop(listener, limits, options.threads, hooks(), counters, holdings) {}

    EventLoop::Hooks hooks() {
        return {
            .client = [this](const RequestHead& head,
                             const std::string& address) { return access.clientOf(head, address); },
            .quick = [this](const Exchange& exchange) { return quick(exchange); },
            .admit = [this](const RequestHead& head) { return refusal(head); },
            .refuse = routes.refuse,
            .handle = [this](Exchange& exchange,
                             ResponseWriter& writer) { return adapter.answer(exchange, writer); }};
    }

    // The routes, whose answers pages of allowed origins may read.
    Routes permitted(Routes given) const {
        return {
            .quick = [this, quick = given.quick](const Call& call,
                                                 std::string_view body) -> std::optional<Answer> {
                if (auto answer = quick(call, body)) {
                    return crossOrigin.permitted(call, *std::move(answer));
                }
                return std::nullopt;
            },
            .respond = [this, respond = given.respond](
                           const Call& call) { return crossOrigin.permitted(call, respond(call)); },
            .refuse =
                [this, refuse = given.refuse](const Call& call, const Problem& problem) {
                    return crossOrigin.permitted(call, refuse(call, problem));
                },
            .paths = std::move(given.paths)};
    }

    std::optional<Problem> refusal(const RequestHead& head) const {
        return access.refusal(
            head, std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
    }

    std::optional<Answer> quick(const Exchange& exchange) const {
        const Call call = callOf(exchange);
        if (auto answer = crossOrigin.preflight(call)) return answer;
        if (const auto problem = refusal(exchange.head)) return routes.refuse(call, *problem);
        return routes.quick(call, exchange.body);
    }

    const CrossOrigin crossOrigin;
    const Routes routes;
    const Access access;
    const HttpLimits limits;
    ConnectionCounters counters;
    Listener listener;
    const int port;
    HttplibAdapter adapter;
    Holdings holdings;
    EventLoop loop;
};

HttpServer::HttpServer(const HttpServerOptions& options, Routes routes)
    : parts_(std::make_unique<Parts>(options, std::move(routes))) {}
HttpServer::~HttpServer() = default;

int HttpServer::port() const {
    return parts_->port;
}
void HttpServer::serve() {
    parts_->loop.run();
}
void HttpServer::stop() {
    parts_->adapter.endStreams();
    parts_->loop.stop();
}
Holdings& HttpServer::holdings() {
    return parts_->holdings;
}
const ConnectionCounters& HttpServer::counters() const {
    return parts_->counters;
}

}  // namespace clerestory
