// What GET /metrics tells of frames: of whoever draws. Thread-safe.
#pragma once

#include "plan/frame_plan.h"
#include "server/scene_library.h"

#include <memory>
#include <string>

namespace clerestory {

inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

class Metrics {
public:
    Metrics();
    ~Metrics();

    // From the queue's door to encoded bytes, and of that in the queue.
    void frame(double seconds, double queueSeconds, const FramePlan& plan);
    void notModified();

    // Prometheus text, version 0.0.4.
    std::string text(std::size_t queueDepth, const SceneTotals& scenes) const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace clerestory
