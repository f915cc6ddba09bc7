#include "server/api/request_metrics.h"

#include "server/api/held_metrics.h"
#include "server/base/log.h"
#include "server/base/process.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <sstream>

namespace clerestory {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::Registry;

}  // namespace

struct RequestMetrics::Families {
    mutable Registry registry;
    prometheus::Family<prometheus::Counter>& requests =
        BuildCounter()
            .Name("clerestory_requests_total")
            .Help("Requests answered, by route and status")
            .Register(registry);
    prometheus::Family<prometheus::Counter>& refusals =
        BuildCounter()
            .Name("clerestory_refusals_total")
            .Help("Requests refused, by the code of the problem")
            .Register(registry);
    prometheus::Family<prometheus::Gauge>& connections = BuildGauge()
                                                             .Name("clerestory_connections")
                                                             .Help("Connections that are open")
                                                             .Register(registry);
    prometheus::Family<prometheus::Gauge>& connectionEvents =
        BuildGauge()
            .Name("clerestory_connection_events")
            .Help("Connections since the start, by what became of them")
            .Register(registry);
    HeldMetrics held{registry, "clerestory_held"};
    prometheus::Family<prometheus::Gauge>& cacheEvents =
        BuildGauge()
            .Name("clerestory_frame_cache_events")
            .Help("Frames looked up in the frame cache since the start, by result; and evictions")
            .Register(registry);
    prometheus::Gauge& cacheBytes = BuildGauge()
                                        .Name("clerestory_frame_cache_bytes")
                                        .Help("Memory of the frame cache")
                                        .Register(registry)
                                        .Add({});
    prometheus::Gauge& cacheEntries = BuildGauge()
                                          .Name("clerestory_frame_cache_entries")
                                          .Help("Frames in the frame cache")
                                          .Register(registry)
                                          .Add({});
    prometheus::Gauge& logDropped = BuildGauge()
                                        .Name("clerestory_log_lines_dropped")
                                        .Help("Dropped lines of the log")
                                        .Register(registry)
                                        .Add({});
    prometheus::Family<prometheus::Gauge>& workers =
        BuildGauge()
            .Name("clerestory_workers")
            .Help(
                "Render workers that live, by what they do; warm: the active ones that have "
                "compiled "
                "the shaders of the default scene; a warm standby holds the same scenes")
            .Register(registry);
    prometheus::Family<prometheus::Gauge>& workerScenes =
        BuildGauge()
            .Name("clerestory_worker_scenes")
            .Help("Scenes that a render worker holds; the standby follows the one that answers")
            .Register(registry);
    prometheus::Family<prometheus::Gauge>& workerEvents =
        BuildGauge()
            .Name("clerestory_worker_events")
            .Help("Render workers and their calls since the start, by what became of them")
            .Register(registry);
    prometheus::Gauge& resident = BuildGauge()
                                      .Name("clerestory_http_resident_memory_bytes")
                                      .Help("Resident memory of the process that clients reach")
                                      .Register(registry)
                                      .Add({});
    prometheus::Gauge& allocated =
        BuildGauge()
            .Name("clerestory_http_allocated_bytes")
            .Help("What the process that clients reach has allocated and not given back")
            .Register(registry)
            .Add({});
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
                            Pool::streams, Pool::views, Pool::waits}) {
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
    std::ostringstream out;
    prometheus::TextSerializer().Serialize(out, families_->registry.Collect());
    return out.str();
}

}  // namespace clerestory
