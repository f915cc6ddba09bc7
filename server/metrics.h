// Counters and histograms for GET /metrics. Thread-safe.
#pragma once

#include "plan/frame_plan.h"
#include "server/front/counters.h"

#include <memory>
#include <string>

namespace clerestory {

class Metrics {
public:
    Metrics();
    ~Metrics();

    void request(const std::string& route, int status);
    void refused(const std::string& code);
    // From the queue's door to encoded bytes, and of that in the queue.
    void frame(double seconds, double queueSeconds, const FramePlan& plan);
    void notModified();

    // Prometheus text, version 0.0.4.
    std::string text(std::size_t queueDepth, const FrontCounters& front) const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace clerestory
