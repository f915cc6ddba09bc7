#include "server/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <spdlog/async.h>

#include <unistd.h>

#include <fstream>
#include <sstream>

namespace clerestory {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Registry;

double residentBytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0.0, resident = 0.0;
    file >> pages >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

struct Metrics::Families {
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
    prometheus::Family<prometheus::Counter>& passes = BuildCounter()
                                                          .Name("clerestory_passes_total")
                                                          .Help("Passes drawn, by kind")
                                                          .Register(registry);
    prometheus::Counter& notModified = BuildCounter()
                                           .Name("clerestory_not_modified_total")
                                           .Help("Frames answered 304, without drawing")
                                           .Register(registry)
                                           .Add({});
    prometheus::Histogram& frameSeconds =
        BuildHistogram()
            .Name("clerestory_frame_seconds")
            .Help("From the door of the queue to encoded bytes")
            .Register(registry)
            .Add({}, prometheus::Histogram::BucketBoundaries{0.002, 0.005, 0.01, 0.02, 0.05, 0.1,
                                                             0.2, 0.5, 1.0, 2.0, 5.0, 10.0});
    prometheus::Histogram& queueSeconds =
        BuildHistogram()
            .Name("clerestory_queue_seconds")
            .Help("From the door of the queue to the begin of the work")
            .Register(registry)
            .Add({}, prometheus::Histogram::BucketBoundaries{0.001, 0.002, 0.005, 0.01, 0.02, 0.05,
                                                             0.1, 0.2, 0.5, 1.0, 2.0, 5.0});
    prometheus::Family<prometheus::Gauge>& connections = BuildGauge()
                                                             .Name("clerestory_connections")
                                                             .Help("Connections that are open")
                                                             .Register(registry);
    prometheus::Family<prometheus::Gauge>& connectionEvents =
        BuildGauge()
            .Name("clerestory_connection_events")
            .Help("Connections since the start, by what became of them")
            .Register(registry);
    prometheus::Gauge& logDropped = BuildGauge()
                                        .Name("clerestory_log_lines_dropped")
                                        .Help("Lines of the log that nobody took in time")
                                        .Register(registry)
                                        .Add({});
    prometheus::Gauge& queueDepth = BuildGauge()
                                        .Name("clerestory_queue_depth")
                                        .Help("Frames waiting or being drawn")
                                        .Register(registry)
                                        .Add({});
    prometheus::Gauge& resident = BuildGauge()
                                      .Name("process_resident_memory_bytes")
                                      .Help("Resident memory size in bytes")
                                      .Register(registry)
                                      .Add({});
};

Metrics::Metrics() : families_(std::make_unique<Families>()) {}
Metrics::~Metrics() = default;

void Metrics::request(const std::string& route, int status) {
    families_->requests.Add({{"route", route}, {"status", std::to_string(status)}}).Increment();
}

void Metrics::refused(const std::string& code) {
    families_->refusals.Add({{"reason", code}}).Increment();
}

void Metrics::frame(double seconds, double queueSeconds, const FramePlan& plan) {
    families_->frameSeconds.Observe(seconds);
    families_->queueSeconds.Observe(queueSeconds);
    for (const Pass& pass : plan.passes) {
        families_->passes.Add({{"kind", std::string(nameOf(pass.kind))}}).Increment();
    }
}

void Metrics::notModified() {
    families_->notModified.Increment();
}

std::string Metrics::text(std::size_t queueDepth, const FrontCounters& front) const {
    const std::pair<const char*, std::uint64_t> events[] = {
        {"accepted", front.accepted},       {"evicted", front.evicted},
        {"turnedAway", front.turnedAway},   {"acceptError", front.acceptErrors},
        {"requestTimeout", front.timeouts}, {"answerStalled", front.stalled},
        {"clientLeft", front.clientsLeft}};
    for (const auto& [name, count] : events) {
        families_->connectionEvents.Add({{"event", name}}).Set(static_cast<double>(count));
    }
    if (const auto log = spdlog::thread_pool()) {
        families_->logDropped.Set(static_cast<double>(log->overrun_counter()));
    }
    families_->connections.Add({}).Set(static_cast<double>(front.open));
    families_->queueDepth.Set(static_cast<double>(queueDepth));
    families_->resident.Set(residentBytes());
    std::ostringstream out;
    prometheus::TextSerializer().Serialize(out, families_->registry.Collect());
    return out.str();
}

}  // namespace clerestory
