#include "server/api/metrics.h"

#include "server/api/held_metrics.h"
#include "server/base/process.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <map>
#include <set>
#include <sstream>

namespace clerestory {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Registry;

prometheus::Histogram::BucketBoundaries secondsBuckets() {
    return {0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0};
}

}  // namespace

struct Metrics::Families {
    mutable Registry registry;
    prometheus::Family<prometheus::Counter>& passes = BuildCounter()
                                                          .Name("clerestory_passes_total")
                                                          .Help("Passes drawn, by kind")
                                                          .Register(registry);
    prometheus::Family<prometheus::Counter>& skipped =
        BuildCounter()
            .Name("clerestory_skipped_total")
            .Help("Work that plans left out, by effect")
            .Register(registry);
    prometheus::Family<prometheus::Counter>& maps =
        BuildCounter()
            .Name("clerestory_maps_total")
            .Help("Resident maps that frames read, by whether they were drawn or reused")
            .Register(registry);
    prometheus::Family<prometheus::Histogram>& spans =
        BuildHistogram()
            .Name("clerestory_span_seconds")
            .Help("Time of the parts of a frame: queue, plan, passes by kind, readback, encode")
            .Register(registry);
    prometheus::Counter& notModified = BuildCounter()
                                           .Name("clerestory_not_modified_total")
                                           .Help("Frames answered 304, without drawing")
                                           .Register(registry)
                                           .Add({});
    prometheus::Histogram& frameSeconds =
        BuildHistogram()
            .Name("clerestory_frame_seconds")
            .Help("Time from entering the queue to encoded bytes")
            .Register(registry)
            .Add({}, prometheus::Histogram::BucketBoundaries{0.002, 0.005, 0.01, 0.02, 0.05, 0.1,
                                                             0.2, 0.5, 1.0, 2.0, 5.0, 10.0});
    prometheus::Histogram& queueSeconds =
        BuildHistogram()
            .Name("clerestory_queue_seconds")
            .Help("Time from entering the queue to the start of the work")
            .Register(registry)
            .Add({}, secondsBuckets());
    prometheus::Counter& programs = BuildCounter()
                                        .Name("clerestory_shader_programs_total")
                                        .Help("Shader programs linked")
                                        .Register(registry)
                                        .Add({});
    prometheus::Counter& pipelines =
        BuildCounter()
            .Name("clerestory_shader_pipelines_total")
            .Help("Programs drawn for the first time with a fixed state and target format")
            .Register(registry)
            .Add({});
    prometheus::Counter& compileSeconds =
        BuildCounter()
            .Name("clerestory_shader_compile_seconds_total")
            .Help("Time of compiling shaders; frames wait for it beyond their deadlines")
            .Register(registry)
            .Add({});
    prometheus::Gauge& queueDepth = BuildGauge()
                                        .Name("clerestory_queue_depth")
                                        .Help("Frames waiting or being drawn")
                                        .Register(registry)
                                        .Add({});
    HeldMetrics held{registry, "clerestory_renderer_held"};
    prometheus::Family<prometheus::Gauge>& sceneBytes = BuildGauge()
                                                            .Name("clerestory_scene_bytes")
                                                            .Help("Memory of loaded scenes")
                                                            .Register(registry);
    prometheus::Family<prometheus::Gauge>& scenes =
        BuildGauge().Name("clerestory_scenes").Help("Scenes, by state").Register(registry);
    prometheus::Gauge& evicted = BuildGauge()
                                     .Name("clerestory_scene_evictions")
                                     .Help("Scenes unloaded since the start for lack of memory")
                                     .Register(registry)
                                     .Add({});

    void setCompiled(const CompileTotals& all) {
        const auto raise = [](prometheus::Counter& counter, double to) {
            counter.Increment(to - counter.Value());
        };
        raise(programs, static_cast<double>(all.programs));
        raise(pipelines, static_cast<double>(all.pipelines));
        raise(compileSeconds, all.seconds);
    }
    void tell(const SceneTotals& all) {
        const auto set = [](auto& family, const char* label, const char* name, auto value) {
            family.Add({{label, name}}).Set(static_cast<double>(value));
        };
        set(sceneBytes, "kind", "meshes", all.bytes.meshes);
        set(sceneBytes, "kind", "textures", all.bytes.textures);
        set(sceneBytes, "kind", "maps", all.bytes.maps);
        set(scenes, "state", "loaded", all.loaded);
        set(scenes, "state", "uploaded", all.uploads);
        evicted.Set(static_cast<double>(all.evicted));
    }

    prometheus::Gauge& resident = BuildGauge()
                                      .Name("process_resident_memory_bytes")
                                      .Help("Resident memory size in bytes")
                                      .Register(registry)
                                      .Add({});
    prometheus::Gauge& allocated =
        BuildGauge()
            .Name("clerestory_allocated_bytes")
            .Help("Memory allocated by the renderer's process and not freed")
            .Register(registry)
            .Add({});
};

// A family is its lines "# HELP" and "# TYPE", then its samples; those of all renderers follow each
// other.
std::string joinedMetrics(const std::vector<std::pair<std::size_t, std::string>>& texts) {
    struct Lines {
        std::string head, samples;
    };
    std::map<std::string, Lines> families;
    for (const auto& [number, text] : texts) {
        const std::string label = "renderer=\"" + std::to_string(number) + "\"";
        std::istringstream in(text);
        Lines* family = nullptr;
        for (std::string line; std::getline(in, line);) {
            if (line.rfind("# HELP ", 0) == 0) {
                family = &families[line.substr(7, line.find(' ', 7) - 7)];
                family->head = line + '\n';
            } else if (line.rfind("# TYPE ", 0) == 0) {
                if (!family) continue;
                family->head += line + '\n';
            } else if (family && !line.empty()) {
                const std::size_t end = line.find_first_of("{ ");
                if (end == std::string::npos) continue;
                const bool hasLabels = line[end] == '{';
                family->samples += line.substr(0, end) + '{' + label + (hasLabels ? "," : "}") +
                                   line.substr(hasLabels ? end + 1 : end) + '\n';
            }
        }
    }
    std::string all;
    for (const auto& [name, lines] : families) all += lines.head + lines.samples;
    return all;
}

Metrics::Metrics() : families_(std::make_unique<Families>()) {}
Metrics::~Metrics() = default;

void Metrics::frame(const Frame& frame, double seconds, double queueSeconds, double encodeSeconds) {
    families_->frameSeconds.Observe(seconds);
    families_->queueSeconds.Observe(queueSeconds);
    std::map<std::string, double> spans = {{"queue", queueSeconds},
                                           {"plan", 1e-3 * frame.planMs},
                                           {"readback", 1e-3 * frame.readbackMs},
                                           {"encode", encodeSeconds}};
    for (const PassTime& time : frame.passTimes) spans[time.kind] += 1e-3 * time.milliseconds;
    for (const auto& [name, spent] : spans) {
        families_->spans.Add({{"span", name}}, secondsBuckets()).Observe(spent);
    }
    std::set<TargetId> drawn;
    for (const Pass& pass : frame.plan.passes) {
        families_->passes.Add({{"kind", std::string(pass.kind())}}).Increment();
        drawn.insert(pass.target);
    }
    for (const Skipped& left : frame.plan.skipped) {
        families_->skipped.Add({{"effect", std::string(nameOf(left.effect))}}).Increment();
    }
    for (TargetId id = 0; id < frame.plan.targets.size(); ++id) {
        if (frame.plan.targets[id].residentKey == 0) continue;
        families_->maps.Add({{"state", drawn.contains(id) ? "drawn" : "resident"}}).Increment();
    }
}

void Metrics::notModified() {
    families_->notModified.Increment();
}

std::string Metrics::text(const State& state) const {
    families_->tell(state.scenes);
    families_->setCompiled(state.compiled);
    families_->queueDepth.Set(static_cast<double>(state.queueDepth));
    families_->held.set(state.queue);
    families_->held.set(nameOf(Pool::jobs), state.jobs);
    families_->resident.Set(residentBytes());
    families_->allocated.Set(allocatedBytes());
    std::ostringstream out;
    prometheus::TextSerializer().Serialize(out, families_->registry.Collect());
    return out.str();
}

}  // namespace clerestory
