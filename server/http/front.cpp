#include "server/http/front.h"

#include "server/http/event_loop.h"

#include <sys/resource.h>

#include <algorithm>

namespace clerestory {
namespace {

// Of descriptors: for scenes, importers, the driver and what runs without asking.
constexpr std::size_t kOtherDescriptors = 64;

// No more connections than there are descriptors, which the system lets a program raise.
FrontLimits affordable(FrontLimits limits) {
    rlimit files{};
    if (getrlimit(RLIMIT_NOFILE, &files) != 0) return limits;
    const rlim_t wanted = limits.connections + kOtherDescriptors;
    if (files.rlim_cur < wanted) {
        files.rlim_cur = std::min(wanted, files.rlim_max);
        setrlimit(RLIMIT_NOFILE, &files);
    }
    const auto most = static_cast<std::size_t>(files.rlim_cur);
    const std::size_t ours = std::max(most, 2 * kOtherDescriptors) - kOtherDescriptors;
    limits.connections = std::min(limits.connections, ours);
    return limits;
}

}  // namespace

class Front::Parts {
public:
    Parts(const FrontOptions& options, Routes given)
        : routes(std::move(given)),
          access(options.access, routes.paths),
          limits(affordable(options.limits)),
          listener(options.host, options.port),
          port(listener.port()),
          library(limits, routes.respond, routes.refuse),
          loop(listener, limits, options.threads, hooks(), counters) {}

    EventLoop::Hooks hooks() {
        return {
            .client = [this](const RequestHead& head,
                             const std::string& address) { return access.clientOf(head, address); },
            .quick = [this](const Exchange& exchange) { return quick(exchange); },
            .admit = [this](const RequestHead& head) { return refusal(head); },
            .refuse = routes.refuse,
            .answer = [this](Exchange& exchange,
                             ResponseWriter& writer) { return library.answer(exchange, writer); }};
    }

    std::optional<Problem> refusal(const RequestHead& head) const {
        return access.refusal(
            head, std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
    }

    std::optional<Answer> quick(const Exchange& exchange) const {
        const Call call = callOf(exchange);
        if (const auto problem = refusal(exchange.head)) return routes.refuse(call, *problem);
        return routes.quick(call);
    }

    const Routes routes;
    const Access access;
    const FrontLimits limits;
    FrontCounters counters;
    Listener listener;
    const int port;
    HttplibAdapter library;
    EventLoop loop;
};

Front::Front(const FrontOptions& options, Routes routes)
    : parts_(std::make_unique<Parts>(options, std::move(routes))) {}
Front::~Front() = default;

int Front::port() const {
    return parts_->port;
}
void Front::serve() {
    parts_->loop.run();
}
void Front::stop() {
    parts_->library.endStreams();
    parts_->loop.stop();
}
const FrontCounters& Front::counters() const {
    return parts_->counters;
}

}  // namespace clerestory
