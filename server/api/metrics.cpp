#include "server/api/metrics.h"

#include "server/api/held_metrics.h"
#include "server/api/metric_families.h"
#include "server/base/process.h"

#include <map>
#include <set>
#include <sstream>

namespace clerestory {
namespace {

MetricFamilies::Buckets secondsBuckets() {
    return {0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0};
}

}  // namespace

struct Metrics::Families {
    MetricFamilies families;
    MetricFamilies::Counters& passes =
        families.counters("clerestory_passes_total", "Passes drawn, by kind");
    MetricFamilies::Counters& skipped =
        families.counters("clerestory_skipped_total", "Work that plans left out, by effect");
    MetricFamilies::Counters& maps =
        families.counters("clerestory_maps_total",
                          "Resident maps that frames read, by whether they were drawn or reused");
    MetricFamilies::Histograms& spans = families.histograms(
        "clerestory_span_seconds",
        "Time of the parts of a frame: queue, plan, passes by kind, readback, encode");
    prometheus::Counter& notModified =
        families.counter("clerestory_not_modified_total", "Frames answered 304, without drawing");
    prometheus::Histogram& frameSeconds = families.histogram(
        "clerestory_frame_seconds", "Time from entering the queue to encoded bytes",
        MetricFamilies::Buckets{0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0,
                                10.0});
    prometheus::Histogram& queueSeconds = families.histogram(
        "clerestory_queue_seconds", "Time from entering the queue to the start of the work",
        secondsBuckets());
    prometheus::Counter& programs =
        families.counter("clerestory_shader_programs_total", "Shader programs linked");
    prometheus::Counter& pipelines =
        families.counter("clerestory_shader_pipelines_total",
                         "Programs drawn for the first time with a fixed state and target format");
    prometheus::Counter& compileSeconds =
        families.counter("clerestory_shader_compile_seconds_total",
                         "Time of compiling shaders; frames wait for it beyond their deadlines");
    prometheus::Gauge& queueDepth =
        families.gauge("clerestory_queue_depth", "Frames waiting or being drawn");
    HeldMetrics held{families, "clerestory_renderer_held"};
    MetricFamilies::Gauges& sceneBytes =
        families.gauges("clerestory_scene_bytes", "Memory of loaded scenes and of uploaded environment maps");
    MetricFamilies::Gauges& scenes = families.gauges("clerestory_scenes", "Scenes, by state");
    prometheus::Gauge& evicted = families.gauge(
        "clerestory_scene_evictions", "Scenes unloaded since the start for lack of memory");

    void setCompiled(const CompileTotals& all) {
        const auto raise = [](prometheus::Counter& counter, double to) {
            counter.Increment(to - counter.Value());
        };
        raise(programs, static_cast<double>(all.programs));
        raise(pipelines, static_cast<double>(all.pipelines));
        raise(compileSeconds, all.seconds);
    }
    void setScenes(const SceneTotals& all) {
        const auto set = [](auto& family, const char* label, const char* name, auto value) {
            family.Add({{label, name}}).Set(static_cast<double>(value));
        };
        set(sceneBytes, "kind", "meshes", all.bytes.meshes);
        set(sceneBytes, "kind", "textures", all.bytes.textures);
        set(sceneBytes, "kind", "maps", all.bytes.maps);
        set(sceneBytes, "kind", "uploadedMaps", all.uploadedMapBytes);
        set(scenes, "state", "loaded", all.loaded);
        set(scenes, "state", "uploaded", all.uploads);
        evicted.Set(static_cast<double>(all.evicted));
    }

    prometheus::Gauge& resident =
        families.gauge("process_resident_memory_bytes", "Resident memory size in bytes");
    prometheus::Gauge& allocated = families.gauge(
        "clerestory_allocated_bytes", "Memory allocated by the renderer's process and not freed");
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
    families_->setScenes(state.scenes);
    families_->setCompiled(state.compiled);
    families_->queueDepth.Set(static_cast<double>(state.queueDepth));
    families_->held.set(state.queue);
    families_->held.set(nameOf(Pool::jobs), state.jobs);
    families_->resident.Set(residentBytes());
    families_->allocated.Set(allocatedBytes());
    return families_->families.text();
}

}  // namespace clerestory
