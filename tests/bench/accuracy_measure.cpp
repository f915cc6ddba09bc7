#include "accuracy_measure.h"
#include "scene/default_view.h"

#include "room_scene.h"
#include "scenes.h"
#include "statistics.h"

namespace clerestory::bench {
namespace {

constexpr double kStep = 1e-3;  // radians that the camera turns from frame to frame
// No more frames are begun in a turn of this many milliseconds: slow ones need fewer for a median.
constexpr double kMaxTurn = 1500.0;

// Whether two plans draw the same; what else was weighed does not matter.
bool drawSame(FramePlan a, FramePlan b) {
    a.skipped = b.skipped = {};
    a.decisions = b.decisions = {};
    return a == b;
}

bool isPreset(const Accuracy& accuracy) {
    return accuracy == accuracyOf(accuracy.preset);
}

struct TimedFrame {
    std::vector<double> wall, processor;
};

class Subject {
public:
    Subject(const AccuracyScene& scene, const MeasureOptions& options)
        : scene_(roomOrScene(scene.argument)), options_(options) {
        view_ = defaultView(scene_);
        for (const std::string& name : builtinEnvironmentNames()) {
            maps_[name] = std::make_shared<const EnvironmentMap>(*builtinEnvironment(name));
        }
        overrides_ = scene.overrides;
        renderer_.addScene(scene_);
        renderer_.completeLight(request(accuracyOf(Preset::standard)));
    }

    FrameRequest request(const Accuracy& accuracy, double angle = 0.0) const {
        FrameRequest r = turned(scene_.id, view_, angle);
        r.width = options_.width;
        r.height = options_.height;
        r.overrides = overrides_;
        r.effects.shadows = r.effects.indirectLight = true;
        r.accuracy = accuracy;
        return r;
    }

    std::vector<Accuracy> thatDiffer(const std::vector<Accuracy>& settings) {
        std::vector<Accuracy> kept;
        std::vector<FramePlan> plans;
        for (const Accuracy& a : settings) {
            renderer_.forgetMaps();  // so that the plan contains the passes that fill them
            FramePlan plan = renderer_.plan(request(a));
            bool known = false;
            for (const FramePlan& p : plans) known = known || drawSame(p, plan);
            if (known && !isPreset(a)) continue;
            kept.push_back(a);
            plans.push_back(std::move(plan));
        }
        return kept;
    }

    ReferenceRender truth() const {
        const FrameRequest frame = request(accuracyOf(Preset::standard));
        const Stopwatch watch;
        auto image = traceReference({.scene = scene_,
                                     .frame = frame,
                                     .environment = *maps_.at(scene_.environment),
                                     .maps = maps_,
                                     .mode = ReferenceMode::full,
                                     .samples = options_.samples});
        return {*std::move(image), watch.milliseconds()};
    }

    Comparison compared(const std::vector<Accuracy>& settings, const ReferenceRender& truth) {
        ComparisonRequest comparison;
        comparison.frame = request(accuracyOf(Preset::standard));
        comparison.settings = settings;
        comparison.samples = options_.samples;
        comparison.frames = 1;
        return *compare(comparison, scene_, truth, [&](const FrameRequest& frame) {
            renderer_.completeLight(frame);
            const Stopwatch watch;
            Frame drawn = renderer_.render(frame);
            return DrawnFrame{std::move(drawn.image), watch.milliseconds(), std::move(drawn.plan)};
        });
    }

    std::vector<TimedFrame> clocked(const std::vector<Accuracy>& settings) {
        std::vector<TimedFrame> all(settings.size());
        for (int round = 0; round < options_.rounds; ++round) {
            for (std::size_t s = 0; s < settings.size(); ++s) {
                // Draws the maps that the others' have pushed out.
                renderer_.render(request(settings[s], -kStep));
                const Stopwatch turn;
                for (int i = 0; i < options_.framesPerRound; ++i) {
                    if (i > 0 && turn.milliseconds() > kMaxTurn) break;
                    const FrameRequest frame = request(settings[s], kStep * i);
                    const double before = processorMilliseconds();
                    const Stopwatch watch;
                    renderer_.render(frame);
                    all[s].wall.push_back(watch.milliseconds());
                    all[s].processor.push_back(processorMilliseconds() - before);
                }
            }
        }
        return all;
    }

    RendererIdentity identity() const { return renderer_.identity(); }

private:
    Scene scene_;
    MeasureOptions options_;
    DefaultView view_;
    EnvironmentMaps maps_;
    std::vector<MaterialOverride> overrides_;
    Renderer renderer_{RendererOptions{}};
};

}  // namespace

Measured measureAccuracy(const AccuracyScene& scene, const std::vector<Accuracy>& settings,
                         const MeasureOptions& options) {
    Subject subject(scene, options);
    const std::vector<Accuracy> kept = subject.thatDiffer(settings);
    const ReferenceRender truth = subject.truth();
    const Comparison comparison = subject.compared(kept, truth);
    const std::vector<TimedFrame> clocks = subject.clocked(kept);

    Measured measured{.truthMs = truth.milliseconds,
                      .renderer = subject.identity().renderer + ", " + subject.identity().version,
                      .software = subject.identity().software};
    for (std::size_t s = 0; s < kept.size(); ++s) {
        const SettingResult& result = comparison.settings[s];
        Point point{.scene = scene.name,
                    .setting = result.name,
                    .medianMs = median(clocks[s].wall),
                    .p95Ms = percentile(clocks[s].wall, 0.95),
                    .coldMs = result.coldMs,
                    .processorMs = median(clocks[s].processor),
                    .totals = result.totals,
                    .relMse = result.frame.relMse,
                    .relMseNoise = comparison.relMseNoise,
                    .relMseOff = comparison.relMseOff,
                    .closedGap = result.closedGap,
                    .frameRelMse = result.frame.relMse,
                    .psnr = result.displayed.psnr,
                    .decibels = result.displayed.decibels,
                    .modelDecibels = result.modelDecibels};
        if (isPreset(result.accuracy)) point.preset = result.accuracy.preset;
        measured.points.push_back(point);
        for (const EffectErrors& e : result.effects) {
            point.effect = e.effect;
            point.relMse = e.errors.relMse;
            point.relMseNoise = e.relMseNoise;
            point.relMseOff = e.relMseOff;
            point.closedGap = e.closedGap;
            measured.points.push_back(point);
        }
    }
    return measured;
}

}  // namespace clerestory::bench
