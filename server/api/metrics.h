// The metrics of frames, counted in the process that draws. Thread-safe.
#pragma once

#include "renderer.h"
#include "server/scenes/scene_library.h"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {

inline constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

// The texts of several renderers as one: each sample has a label `renderer`, its number.
std::string joinedMetrics(const std::vector<std::pair<std::size_t, std::string>>& texts);

class Metrics {
public:
    Metrics();
    ~Metrics();

    // Seconds from entering the queue to encoded bytes; the parts spent waiting and encoding.
    void frame(const Frame& frame, double seconds, double queueSeconds, double encodeSeconds);
    void notModified();

    // What others count.
    struct State {
        std::size_t queueDepth = 0;  // waiting or running
        QueueUsage queue;
        Holdings::Usage jobs;  // that wait or run
        CompileTotals compiled;
        SceneTotals scenes;
    };
    // Prometheus text, version 0.0.4.
    std::string text(const State& state) const;

private:
    struct Families;
    std::unique_ptr<Families> families_;
};

}  // namespace clerestory
