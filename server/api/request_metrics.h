// Metrics of requests, connections and workers (GET /metrics), for the process that clients reach.
// Thread-safe.
#pragma once

#include "server/api/backend.h"
#include "server/api/frame_cache.h"
#include "server/base/holdings.h"
#include "server/http/limits.h"

#include <memory>
#include <string>

namespace clerestory {

class RequestMetrics {
public:
    RequestMetrics();
    ~RequestMetrics();

    void request(const std::string& route, int status);
    void refused(ProblemCode code);

    // Prometheus text, version 0.0.4. Its names differ from those of Metrics::text(). `workers`:
    // empty where the renderer is in this process.
    std::string text(const ConnectionCounters& front, const Holdings& holdings,
                     const FrameCacheCounters& cache,
                     const std::optional<WorkerStatus>& workers) const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace clerestory
