// What clients hold of bounded pools, as metrics. Each process has an account of its own pools:
// that of connections, bodies, answers, streams and views in the process that clients reach, that
// of the queue and of jobs in the process that draws (with several renderers, the queue is in the
// first).
//
//     HeldMetrics held(registry, "clerestory_held");
//     held.set("jobs", account.usage(Pool::jobs));
#pragma once

#include "server/base/holdings.h"
#include "server/queue/fair_queue.h"

#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>

#include <string>
#include <string_view>

namespace clerestory {

class HeldMetrics {
public:
    // Registers NAME (the sums), NAME_by_one (the most of one client) and NAME_clients (how many
    // hold something), each with a label `pool`. The registry must outlive this.
    HeldMetrics(prometheus::Registry& registry, const std::string& name);

    void set(std::string_view pool, const Holdings::Usage& usage);
    void set(const QueueUsage& queue);  // pools queueEntries and queueMilliseconds

private:
    using Gauges = prometheus::Family<prometheus::Gauge>;
    Gauges &total_, &byOne_, &clients_;
};

}  // namespace clerestory
