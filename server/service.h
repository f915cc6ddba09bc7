// The running server: its parts, and the order in which they start and stop.
#pragma once

#include "server/budgets.h"
#include "server/config.h"
#include "server/jobs.h"
#include "server/live_views.h"
#include "server/metrics.h"
#include "server/streams.h"
#include "server/truths.h"

#include <atomic>
#include <thread>

namespace clerestory {

class Service {
public:
    // Renderer, scenes and port stand when this returns; nobody is answered before start(). Throws
    // std::runtime_error with one line for people.
    explicit Service(const Config& config);
    ~Service();
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    void start();
    // Refuses new frames (503) while those it has are finished, then closes the port.
    void stop();

    int port() const { return http_.port(); }
    const Config& config() const { return config_; }
    RenderQueue& queue() { return queue_; }
    SceneLibrary& library() { return library_; }
    Metrics& metrics() { return metrics_; }
    const FrontCounters& connections() const { return http_.counters(); }
    Jobs& jobs() { return jobs_; }
    Truths& truths() { return truths_; }
    Budgets& budgets() { return budgets_; }
    Streams& streams() { return streams_; }
    LiveViews& views() { return views_; }
    // Whoever sends for longer than a frame takes looks at it now and then.
    bool stopping() const { return stopping_; }

    // Draws one tiny frame of a scene of the server's own, unless one was drawn within the last
    // seconds. Throws RequestError 503 when that fails.
    void checkCanary();
    void frameWasDrawn();

private:
    const Config config_;
    Metrics metrics_;
    Front http_;  // binds first: a taken port is known before any work is done
    RenderQueue queue_;
    SceneLibrary library_;
    Truths truths_;
    Budgets budgets_;
    Streams streams_;
    LiveViews views_;
    std::atomic<bool> stopping_{false};
    Jobs jobs_;  // its work uses all of the above
    std::thread listener_;
    std::atomic<std::int64_t> lastDrawn_{0};  // Clock, milliseconds; 0: never
};

}  // namespace clerestory
