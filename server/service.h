// What frames are made of: renderer, scenes, long jobs. Answers calls, and knows no connection. It
// lives in the server's process or in a worker of its own.
#pragma once

#include "server/api/metrics.h"
#include "server/config.h"
#include "server/jobs/budgets.h"
#include "server/jobs/jobs.h"
#include "server/jobs/reference_cache.h"

#include <atomic>

namespace clerestory {

class Service {
public:
    // Renderer and scenes stand when this returns. Throws std::runtime_error with one line for
    // people.
    explicit Service(const Config& config);
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    // Refuses new frames (503), and returns when those it has are finished.
    void refuseNew() { queue_.refuseNew(); }

    const Config& config() const { return config_; }
    RenderQueue& queue() { return queue_; }
    SceneLibrary& library() { return library_; }
    Metrics& metrics() { return metrics_; }
    Jobs& jobs() { return jobs_; }
    ReferenceCache& truths() { return truths_; }
    Budgets& budgets() { return budgets_; }

    // Draws one tiny frame of a scene of the server's own, unless one was drawn within the last
    // seconds. Throws RequestError 503 when that fails.
    void checkCanary();
    void frameWasDrawn();

private:
    const Config config_;
    Metrics metrics_;
    RenderQueue queue_;
    SceneLibrary library_;
    ReferenceCache truths_;
    Budgets budgets_;
    Jobs jobs_;                               // its work uses all of the above
    std::atomic<std::int64_t> lastDrawn_{0};  // Clock, milliseconds; 0: never
};

}  // namespace clerestory
