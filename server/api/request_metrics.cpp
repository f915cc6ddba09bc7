#include "server/api/request_metrics.h"

#include "server/api/held_metrics.h"
#include "server/api/metric_families.h"
#include "server/base/log.h"
#include "server/base/process.h"

namespace clerestory {
namespace {}  // namespace

struct RequestMetrics::Families {
    MetricFamilies families;
    MetricFamilies::Counters& requests =
        families.counters("clerestory_requests_total", "Requests answered, by route and status");
    MetricFamilies::Counters& refusals = families.counters(
        "clerestory_refusals_total", "Requests refused, by the code of the problem");
    MetricFamilies::Gauges& connections =
        families.gauges("clerestory_connections", "Connections that are open");
    MetricFamilies::Gauges& connectionEvents =
        families.gauges("clerestory_connection_events", "Connections since the start, by outcome");
    HeldMetrics held{families, "clerestory_held"};
    MetricFamilies::Gauges& cacheEvents = families.gauges(
        "clerestory_frame_cache_events",
        "Frames looked up in the frame cache since the start, by result; and evictions");
    prometheus::Gauge& cacheBytes =
        families.gauge("clerestory_frame_cache_bytes", "Memory of the frame cache");
    prometheus::Gauge& cacheEntries =
        families.gauge("clerestory_frame_cache_entries", "Frames in the frame cache");
    prometheus::Gauge& logDropped =
        families.gauge("clerestory_log_lines_dropped", "Dropped lines of the log");
    MetricFamilies::Gauges& workers = families.gauges(
        "clerestory_workers",
        "Running render workers, by role; warm: the active ones that have compiled the "
        "shaders of the default scene; a warm standby holds the same scenes");
    MetricFamilies::Gauges& workerScenes = families.gauges(
        "clerestory_worker_scenes",
        "Scenes that a render worker holds; the standby loads those of the active one");
    MetricFamilies::Gauges& workerEvents = families.gauges(
        "clerestory_worker_events", "Render workers and their calls since the start, by outcome");
    prometheus::Gauge& resident =
        families.gauge("clerestory_http_resident_memory_bytes",
                       "Resident memory of the process that clients reach");
    prometheus::Gauge& allocated =
        families.gauge("clerestory_http_allocated_bytes",
                       "Memory allocated by the process that clients reach and not freed");
};

RequestMetrics::RequestMetrics() : families_(std::make_unique<Families>()) {}
RequestMetrics::~RequestMetrics() = default;

void RequestMetrics::request(const std::string& route, int status) {
    families_->requests.Add({{"route", route}, {"status", std::to_string(status)}}).Increment();
}

void RequestMetrics::refused(ProblemCode code) {
    families_->refusals.Add({{"reason", std::string(nameOf(code))}}).Increment();
}

std::string RequestMetrics::text(const ConnectionCounters& front, const Holdings& holdings,
                                 const FrameCacheCounters& cache,
                                 const std::optional<WorkerStatus>& workers) const {
    const auto set = [](auto& family, const char* label, auto&& rows) {
        for (const auto& [name, count] : rows) {
            family.Add({{label, name}}).Set(static_cast<double>(count));
        }
    };
    using Row = std::pair<const char*, std::uint64_t>;
    set(families_->connectionEvents, "event",
        std::initializer_list<Row>{{"accepted", front.accepted},
                                   {"evicted", front.evicted},
                                   {"turnedAway", front.rejected},
                                   {"acceptError", front.acceptErrors},
                                   {"requestTimeout", front.timeouts},
                                   {"answerStalled", front.stalled},
                                   {"clientLeft", front.disconnected}});
    set(families_->cacheEvents, "event",
        std::initializer_list<Row>{
            {"hit", cache.hits}, {"miss", cache.misses}, {"evicted", cache.evicted}});
    for (const Pool pool : {Pool::connections, Pool::requestBytes, Pool::responseBytes,
                            Pool::smallResponseBytes, Pool::streams, Pool::views, Pool::waits}) {
        families_->held.set(nameOf(pool), holdings.usage(pool));
    }
    families_->cacheBytes.Set(static_cast<double>(cache.bytes));
    families_->cacheEntries.Set(static_cast<double>(cache.entries));
    families_->logDropped.Set(static_cast<double>(logLinesDropped()));
    families_->connections.Add({}).Set(static_cast<double>(front.open));
    if (workers) {
        set(families_->workerEvents, "event",
            std::initializer_list<Row>{{"started", workers->started},
                                       {"ended", workers->ended},
                                       {"silent", workers->silent},
                                       {"callAskedAgain", workers->repeatedCalls},
                                       {"callQuarantined", workers->quarantinedCalls}});
        set(families_->workers, "role",
            std::initializer_list<Row>{{"active", workers->active},
                                       {"warm", workers->warm},
                                       {"standby", workers->hasStandby},
                                       {"warmStandby", workers->standbyIsWarm}});
        if (workers->queue) families_->held.set(*workers->queue);
        set(families_->workerScenes, "role",
            std::initializer_list<Row>{{"active", workers->activeScenes},
                                       {"standby", workers->standbyScenes}});
    }
    families_->resident.Set(residentBytes());
    families_->allocated.Set(allocatedBytes());
    return families_->families.text();
}

}  // namespace clerestory
