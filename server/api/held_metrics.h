// What clients hold of bounded pools, as metrics. Each process has an account of its own pools:
// that of connections, bodies, answers, streams and views in the process that clients reach, that
// of the queue and of jobs in the process that draws (with several renderers, the queue is in the
// first).
//
//     HeldMetrics held(families, "clerestory_held");
//     held.set("jobs", account.usage(Pool::jobs));
#pragma once

#include "server/api/metric_families.h"
#include "server/base/holdings.h"
#include "server/queue/fair_queue.h"

#include <string>
#include <string_view>

namespace clerestory {

class HeldMetrics {
public:
    // Registers NAME (the sums), NAME_by_one (the most of one client) and NAME_clients (how many
    // hold something), each with a label `pool`. The families must outlive this.
    HeldMetrics(MetricFamilies& families, const std::string& name);

    void set(std::string_view pool, const Holdings::Usage& usage);
    void set(const QueueUsage& queue);  // pools queueEntries and queueMilliseconds

private:
    MetricFamilies::Gauges &total_, &byOne_, &clients_;
};

}  // namespace clerestory
