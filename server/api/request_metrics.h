// What GET /metrics tells of requests, connections and workers: of the process that clients reach.
// Thread-safe.
#pragma once

#include "server/http/counters.h"

#include <memory>
#include <string>

namespace clerestory {

class Supervisor;

class RequestMetrics {
public:
    RequestMetrics();
    ~RequestMetrics();

    void request(const std::string& route, int status);
    void refused(const std::string& code);

    // Prometheus text, version 0.0.4. No name in it is one of Metrics::text(). `workers`: null
    // where the renderer lives in this process.
    std::string text(const ConnectionCounters& front, const Supervisor* workers) const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace clerestory
