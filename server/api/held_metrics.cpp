#include "server/api/held_metrics.h"

namespace clerestory {

HeldMetrics::HeldMetrics(MetricFamilies& families, const std::string& name)
    : total_(families.gauges(name, "What clients hold of each pool")),
      byOne_(families.gauges(name + "_by_one", "The most that one client holds of each pool")),
      clients_(families.gauges(name + "_clients", "Clients that hold something of each pool")) {}

void HeldMetrics::set(std::string_view pool, const Holdings::Usage& usage) {
    const prometheus::Labels labels = {{"pool", std::string(pool)}};
    total_.Add(labels).Set(static_cast<double>(usage.total));
    byOne_.Add(labels).Set(static_cast<double>(usage.greatest));
    clients_.Add(labels).Set(static_cast<double>(usage.clients));
}

void HeldMetrics::set(const QueueUsage& queue) {
    set("queueEntries", queue.entries);
    set("queueMilliseconds", queue.milliseconds);
}

}  // namespace clerestory
