// `bench_prices [--width W --height H --rounds N --accuracy PRESET] SCENE...`: every constant of
// the cost model as this machine measures it, next to the compiled-in value; then, for each scene
// and technique, the predicted milliseconds and the measured ones: the frame with the technique
// less the frame with environment maps, in turns, each the fastest of its rounds.
#include "command_line.h"
#include "plan/cost/cost.h"
#include "predictions.h"
#include "prices.h"
#include "program.h"
#include "room_scene.h"
#include "scene/default_view.h"
#include "scenes.h"
#include "statistics.h"

#include <filesystem>

namespace clerestory::bench {
namespace {

// Differences of frames that are smaller are not measurable: milliseconds, and the fraction of the
// frame (in seven runs a difference of two frames of 150 ms was between -15 and 18).
constexpr double kNoise = 10.0, kNoiseShare = 0.1;

struct Row {
    std::string scene;
    Technique technique;
    double predicted = 0.0, measured = 0.0;      // milliseconds
    double frame = 0.0;                          // milliseconds, with environment maps
    double predictedPixels = 0.0, pixels = 0.0;  // of the surfaces served so; 0: not counted
};

// The surfaces that the technique serves in a plan: predicted milliseconds and pixels.
Row predictionOf(const FramePlan& plan, const Technique& technique) {
    Row row{.technique = technique};
    for (const Decision& d : plan.decisions) {
        if (d.effect != technique.effect || d.taken != technique.method) continue;
        row.predictedPixels += d.share * plan.width * plan.height;
        for (const Candidate& c : d.candidates) {
            if (c.method == d.taken) row.predicted += c.milliseconds;
        }
    }
    return row;
}

// The fastest frame of each of two requests, in turns. Each frame changes the environment's
// intensity a little, so that captured cubes are drawn in each.
std::pair<double, double> fastest(Renderer& renderer, FrameRequest a, FrameRequest b, int rounds) {
    double best[2] = {1e9, 1e9};
    for (int i = -2; i < rounds; ++i) {
        for (FrameRequest* request : {&a, &b}) {
            request->environment.intensity = 1.0 + 1e-4 * (i + 3);
            const Stopwatch watch;
            renderer.render(*request);
            double& least = best[request == &b];
            if (i >= 0) least = std::min(least, watch.milliseconds());
        }
    }
    return {best[0], best[1]};
}

void measure(Renderer& renderer, Scene scene, const FrameRequest& shape, int rounds,
             std::vector<Row>& rows) {
    const std::string id = scene.id;
    const bool moves = !scene.clips.empty();
    const DefaultView view = defaultView(scene);
    renderer.addScene(std::move(scene));
    FrameRequest base = turned(id, view, 0.0);
    base.width = shape.width;
    base.height = shape.height;
    base.accuracy = shape.accuracy;
    base.accuracy.planar = PlanarMethod::environment;
    base.accuracy.curved = CurvedMethod::environment;
    base.accuracy.glass = GlassMethod::environment;
    FrameRequest through = maskRequest(base);
    through.output = {.format = OutputFormat::npy, .channel = Channel::through};
    const Image seen = renderer.render(through).image;
    for (const Technique& technique : techniques()) {
        if (technique.method == Method::environment) continue;
        FrameRequest request = base;
        technique.request(request.accuracy);
        Row row = predictionOf(renderer.plan(request), technique);
        if (row.predicted <= 0.0) continue;
        row.scene = id;
        row.pixels = double(maskOf(seen, technique.effect).pixels());
        // The prediction is a frame's share of a capture.
        if (technique.method == Method::probe) row.predicted *= framesPerCapture(moves);
        const auto [without, with] = fastest(renderer, base, request, rounds);
        row.measured = with - without;
        row.frame = without;
        rows.push_back(row);
        std::printf("| %s | %s, %s | %.1f | %.1f | %.2f | %.2f |\n", id.c_str(),
                    std::string(nameOf(technique.effect)).c_str(),
                    std::string(nameOf(technique.method)).c_str(), row.predicted, row.measured,
                    row.measured / row.predicted,
                    row.pixels > 0.0 ? row.predictedPixels / row.pixels : 0.0);
        std::fflush(stdout);
    }
    renderer.removeScene(id);
}

int run(int argc, char** argv) {
    CommandLine line("Prices of the cost model, measured");
    std::vector<std::string> scenes;
    std::string preset = "standard";
    int width = 1280, height = 720, rounds = 11;
    bool constants = true;
    line.addList("scenes", scenes, "built-in ids, files, or room: a scene of this program");
    line.add("--width", width);
    line.add("--height", height);
    line.add("--rounds", rounds, "frames per measurement; the fastest counts");
    line.add("--accuracy", preset, "", {"draft", "standard", "fine"});
    line.addFlag("--constants,!--no-constants", constants, "measure the constants");
    if (const auto status = line.parse(argc, argv)) return *status;

    Renderer renderer{RendererOptions{}};
    std::printf("%s; %ld cores; load %.1f\n\n", renderer.identity().renderer.c_str(),
                sysconf(_SC_NPROCESSORS_ONLN), loadAverage());
    if (constants) {
        std::printf(
            "| constant | measured | compiled in | measured / compiled in |\n|---|---|---|---|\n");
        for (const Price& p : measurePrices(rounds)) {
            std::printf("| %s | %.3g %s | ", p.name.c_str(), p.measured, p.unit);
            if (p.compiledIn > 0.0) {
                std::printf("%.3g %s | %.2f |\n", p.compiledIn, p.unit, p.measured / p.compiledIn);
            } else {
                std::printf("none | |\n");
            }
        }
    }
    if (scenes.empty()) return 0;

    FrameRequest shape;
    shape.width = static_cast<std::uint32_t>(width);
    shape.height = static_cast<std::uint32_t>(height);
    for (const auto& [word, value] : presetChoice().words) {
        if (word == preset) shape.accuracy = accuracyOf(value);
    }
    std::printf(
        "\n%dx%d, accuracy %s\n\n| scene | technique | predicted ms | measured ms | measured / "
        "predicted | predicted pixels / true |\n|---|---|---|---|---|---|\n",
        width, height, preset.c_str());
    std::vector<Row> rows;
    for (const std::string& name : scenes) {
        measure(renderer, roomOrScene(name), shape, rounds, rows);
    }
    std::vector<double> factors;
    double worst = 1.0;
    for (const Row& row : rows) {
        const double noise = std::max(kNoise, kNoiseShare * row.frame);
        if (std::max(row.measured, row.predicted) < noise) continue;
        const double ratio = std::max(row.measured, 0.1) / row.predicted;
        factors.push_back(std::max(ratio, 1.0 / ratio));
        worst = std::max(worst, factors.back());
    }
    if (!factors.empty()) {
        std::printf(
            "\n%zu of %zu rows are above the noise of %.0f ms or %.0f %% of the frame: the median "
            "factor between both is %.2f, the largest %.2f.\n",
            factors.size(), rows.size(), kNoise, 100.0 * kNoiseShare, median(factors), worst);
    }
    return 0;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_prices", clerestory::bench::run, argc, argv);
}
