#include "server/api/held_metrics.h"

namespace clerestory {
namespace {

prometheus::Family<prometheus::Gauge>& gauges(prometheus::Registry& registry,
                                              const std::string& name, const std::string& help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry);
}

}  // namespace

HeldMetrics::HeldMetrics(prometheus::Registry& registry, const std::string& name)
    : total_(gauges(registry, name, "What clients hold of each pool")),
      byOne_(gauges(registry, name + "_by_one", "The most that one client holds of each pool")),
      clients_(gauges(registry, name + "_clients", "Clients that hold something of each pool")) {}

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
