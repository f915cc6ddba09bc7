// `bench_effects [--width W --height H --frames N] SCENE...`: the cost of the effects, alone
// and together, relative to the same frame without them: with resident maps while the camera
// rotates a little, and with everything redrawn in every frame. Settings alternate frame by frame,
// so that other load on the machine affects all equally. Encoding is not counted. Then the
// planner's predicted milliseconds and error of each technique, with the measured ones.
#include "command_line.h"
#include "predictions.h"
#include "program.h"
#include "scene/default_view.h"
#include "scenes.h"
#include "statistics.h"

#include <unistd.h>
#include <map>

namespace clerestory::bench {
namespace {

struct Setting {
    const char* name;
    Effects effects;
};

constexpr Effects kNone{false, false, false, false, false, false, false};
Effects only(bool Effects::*effect) {
    Effects effects = kNone;
    effects.*effect = true;
    return effects;
}
const std::vector<Setting> kSettings = {
    {"base", kNone},
    {"emission", only(&Effects::emission)},
    {"refraction", only(&Effects::refraction)},
    {"planarReflection", only(&Effects::planarReflection)},
    {"environmentReflection", only(&Effects::environmentReflection)},
    {"materialLayers", only(&Effects::materialLayers)},
    {"shadows", only(&Effects::shadows)},
    {"indirectLight", only(&Effects::indirectLight)},
    {"all", {}}};

// The predicted cost of the chosen techniques in the requested view; maps count with a frame's
// share.
double predictedMilliseconds(const FramePlan& plan) {
    double sum = 0.0;
    for (const Decision& d : plan.decisions) {
        for (const Candidate& c : d.candidates) {
            if (c.method == d.taken) sum += c.milliseconds;
        }
    }
    return sum;
}

// Frames of one setting under one condition.
struct Series {
    std::vector<double> wall, processor, plan;
    double predictedMs = 0.0;
    std::map<std::string, std::vector<double>> kinds;
    PlanTotals totals;

    void add(const Frame& frame, double wallMs, double processorMs) {
        wall.push_back(wallMs);
        processor.push_back(processorMs);
        plan.push_back(frame.planMs);
        std::map<std::string, double> sums;
        for (const PassTime& pass : frame.passTimes) sums[pass.kind] += pass.milliseconds;
        sums["readback"] = frame.readbackMs;
        for (const auto& [kind, ms] : sums) kinds[kind].push_back(ms);
        totals = clerestory::totals(frame.plan);
        predictedMs = predictedMilliseconds(frame.plan);
    }
};

struct Subject {
    std::string id;
    DefaultView view;
    FrameRequest shape;

    FrameRequest request(const Effects& effects, double angle) const {
        FrameRequest r = turned(id, view, angle);
        r.width = shape.width;
        r.height = shape.height;
        r.accuracy = shape.accuracy;
        r.effects = effects;
        return r;
    }
};

constexpr double kStep = 0.01;  // radians from frame to frame
constexpr int kWarmFrames = 2;
constexpr double kMinPrediction = 1.0;  // milliseconds; less is lost in the noise of a clock

// The base frame keeps its map: all others are measured by it.
std::vector<Series> measure(Renderer& renderer, const Subject& subject, int frames, bool redraw) {
    std::vector<Series> all(kSettings.size());
    for (const Setting& setting : kSettings) {
        renderer.completeLight(subject.request(setting.effects, 0.0));
    }
    for (int i = -kWarmFrames; i < frames; ++i) {
        for (std::size_t s = 0; s < kSettings.size(); ++s) {
            if (redraw && s > 0) renderer.forgetMaps();
            if (redraw && s == 0) renderer.render(subject.request(kSettings[s].effects, 0.0));
            const double processor = processorMilliseconds();
            const Stopwatch watch;
            const Frame frame = renderer.render(subject.request(kSettings[s].effects, kStep * i));
            const double wall = watch.milliseconds();
            if (i >= 0) all[s].add(frame, wall, processorMilliseconds() - processor);
        }
    }
    return all;
}

// The first frame of a renderer that has just been given the scene.
double coldFrame(const std::string& argument, const Subject& subject, const Effects& effects) {
    Renderer renderer{RendererOptions{}};
    renderer.addScene(loadScene(argument));
    const Stopwatch watch;
    renderer.render(subject.request(effects, 0.0));
    return watch.milliseconds();
}

void printTotals(const char* title, const std::vector<Series>& all) {
    const Series& base = all.front();
    std::printf("\n%s\n\n", title);
    std::printf(
        "| effects | median ms | p95 | of base | processor ms | of base | plan ms | "
        "passes | draws | triangles |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (std::size_t s = 0; s < all.size(); ++s) {
        const Series& x = all[s];
        std::printf("| %s | %.1f | %.1f | %.2f x | %.1f | %.2f x | %.2f | %llu | %llu | %llu |\n",
                    kSettings[s].name, median(x.wall), percentile(x.wall, 0.95),
                    median(x.wall) / median(base.wall), median(x.processor),
                    median(x.processor) / median(base.processor), median(x.plan),
                    static_cast<unsigned long long>(x.totals.passes),
                    static_cast<unsigned long long>(x.totals.draws),
                    static_cast<unsigned long long>(x.totals.triangles));
    }
}

void printKinds(const char* title, const std::vector<Series>& all) {
    std::map<std::string, bool> kinds;
    for (const Series& x : all) {
        for (const auto& [kind, ms] : x.kinds) kinds[kind] = true;
    }
    std::printf("\n%s\n\n| effects |", title);
    for (const auto& [kind, known] : kinds) std::printf(" %s |", kind.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < kinds.size(); ++i) std::printf("---|");
    std::printf("\n");
    for (std::size_t s = 0; s < all.size(); ++s) {
        std::printf("| %s |", kSettings[s].name);
        for (const auto& [kind, known] : kinds) {
            const auto found = all[s].kinds.find(kind);
            if (found == all[s].kinds.end())
                std::printf(" - |");
            else
                std::printf(" %.1f |", median(found->second));
        }
        std::printf("\n");
    }
}

// The predicted and the measured cost of each effect. Predictions are for a reference machine with
// two dedicated cores, so the spread of the ratios matters. Measured is processor time divided by
// the cores, which other programs disturb least.
void printPredictions(const char* title, const std::vector<Series>& all) {
    std::printf(
        "\n%s\n\n| effects | predicted ms | measured ms | measured / predicted "
        "|\n|---|---|---|---|\n",
        title);
    const double cores = static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN));
    std::vector<double> ratios;
    for (std::size_t s = 1; s < all.size(); ++s) {
        const double added = (median(all[s].processor) - median(all.front().processor)) / cores;
        std::printf("| %s | %.1f | %.1f |", kSettings[s].name, all[s].predictedMs, added);
        if (all[s].predictedMs < kMinPrediction || added <= 0.0) {
            std::printf(" - |\n");
            continue;
        }
        ratios.push_back(added / all[s].predictedMs);
        std::printf(" %.2f |\n", ratios.back());
    }
    if (ratios.empty()) return;
    const double middle = median(ratios);
    double worst = 1.0;
    for (const double r : ratios) worst = std::max({worst, r / middle, middle / r});
    std::printf("\nMedian ratio %.2f; the worst is %.2f times as far off.\n", middle, worst);
}

constexpr std::uint32_t kTruthSamples = 64;

// Errors are those of this frame: the reference is traced at its size.
void printExpectedErrors(Renderer& renderer, const Subject& subject, const std::string& argument) {
    const Scene scene = loadScene(argument);  // the renderer's own has no texels
    EnvironmentMaps maps;
    for (const std::string& name : builtinEnvironmentNames()) {
        maps[name] = std::make_shared<const EnvironmentMap>(*builtinEnvironment(name));
    }
    const FrameRequest frame = subject.request(Effects{}, 0.0);
    const auto truth = traceReference({.scene = scene,
                                       .frame = frame,
                                       .environment = *maps.at(scene.environment),
                                       .maps = maps,
                                       .samples = kTruthSamples});
    const auto predictions = measurePredictions(frame, *truth, [&](const FrameRequest& request) {
        Frame drawn = renderer.render(request);
        return DrawnFrame{std::move(drawn.image), 0.0, std::move(drawn.plan)};
    });
    std::printf(
        "\nWhat the planner expects each way to get wrong (root of relMSE), and what it "
        "does, against %u paths a pixel:\n\n%s",
        kTruthSamples, textOf(predictions).c_str());
}

// An effect that nothing in view calls for: the same passes and the same bytes, on and off. Tries
// views all round from where the camera stands, up and down. Prints what was found.
void printUncalledFor(Renderer& renderer, const Subject& subject) {
    for (const Setting& setting : kSettings) {
        if (setting.effects.emission == setting.effects.refraction) continue;  // none or all
        bool found = false;
        for (int turn = 0; turn < 24 && !found; ++turn) {
            FrameRequest on = subject.request(setting.effects, 0.0);
            const double heading = 0.7854 * (turn % 8), rise = 1.2 * (turn / 8 - 1);
            const glm::dvec3 eye = *on.camera.position;
            on.camera.target = eye + glm::dvec3(std::cos(rise) * std::sin(heading), std::sin(rise),
                                                std::cos(rise) * std::cos(heading));
            FrameRequest off = on;
            off.effects = kNone;
            renderer.render(on);
            renderer.render(off);
            const Frame with = renderer.render(on), without = renderer.render(off);
            const bool samePasses = with.plan.passes == without.plan.passes;
            if (!samePasses) continue;
            found = true;
            std::printf("| %s | view %d | %llu = %llu draws | %s |\n", setting.name, turn,
                        static_cast<unsigned long long>(totals(with.plan).draws),
                        static_cast<unsigned long long>(totals(without.plan).draws),
                        with.image.data == without.image.data ? "same bytes" : "OTHER BYTES");
        }
        if (!found) std::printf("| %s | every view calls for it | | |\n", setting.name);
    }
}

void report(const std::string& argument, const FrameRequest& shape, int frames) {
    Scene scene = loadScene(argument);
    const Subject subject{scene.id, defaultView(scene), shape};
    const double coldBase = coldFrame(argument, subject, kNone);
    const double coldAll = coldFrame(argument, subject, Effects{});
    Renderer renderer{RendererOptions{}};
    renderer.addScene(std::move(scene));
    std::printf("\n## %s\n\n%s; %ld cores, load average %.1f; %ux%u, %d frames\n",
                subject.id.c_str(), renderer.identity().renderer.c_str(),
                sysconf(_SC_NPROCESSORS_ONLN), loadAverage(), shape.width, shape.height, frames);
    const std::vector<Series> resident = measure(renderer, subject, frames, false);
    const std::vector<Series> redrawn = measure(renderer, subject, frames, true);
    printTotals("Camera turning, maps of earlier frames at hand:", resident);
    printTotals("Everything redrawn in every frame, except the base frame's map:", redrawn);
    printPredictions("What the planner expected, against what the effects added:", resident);
    printExpectedErrors(renderer, subject, argument);
    printKinds("Median milliseconds of each kind of pass, maps at hand:", resident);
    printKinds("The same, everything redrawn:", redrawn);
    std::printf("\nFirst frame of all: base %.0f ms, all effects %.0f ms.\n", coldBase, coldAll);
    std::printf(
        "\nAn effect that nothing in view calls for:\n\n| effect | view | draws | picture "
        "|\n|---|---|---|---|\n");
    printUncalledFor(renderer, subject);
    std::printf("\nLoad average at the end %.1f\n", loadAverage());
}

int run(int argc, char** argv) {
    CommandLine line("What the effects cost");
    std::vector<std::string> scenes{"chapel"};
    std::string preset = "standard";
    FrameRequest shape;
    int frames = 15;
    line.addList("scenes", scenes, "built-in ids or files");
    line.add("--width", shape.width);
    line.add("--height", shape.height);
    line.add("--frames", frames, "warm frames measured");
    line.add("--accuracy", preset, "", {"draft", "standard", "fine"});
    if (const auto status = line.parse(argc, argv)) return *status;
    for (const auto& [word, value] : presetChoice().words) {
        if (word == preset) shape.accuracy = accuracyOf(value);
    }
    for (const std::string& scene : scenes) report(scene, shape, frames);
    return 0;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_effects", clerestory::bench::run, argc, argv);
}
