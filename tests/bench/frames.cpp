// `bench_frames [--width W --height H --frames N --accuracy PRESET --effects all|none|shadows|full
// --rays automatic|shader|cpu] SCENE...`: the cost of a frame. `all` are all effects but shadows
// and light between surfaces, `shadows` adds shadows, and `full`, the effects of a default request,
// also light between surfaces, which is complete before the first frame is measured. A scene is a
// built-in's id or a file. The camera rotates a little from frame to frame, because a driver may
// skip repeated work. Prints a Markdown table: median and 95th percentile of warm frames, the cold
// first frame, processor time, milliseconds of each pass and of encoding, and memory.
#include "command_line.h"
#include "image/image.h"
#include "program.h"
#include "renderer.h"
#include "scene/default_view.h"
#include "scenes.h"
#include "statistics.h"

#include <malloc.h>
#include <unistd.h>
#include <cstdio>
#include <fstream>
#include <map>

namespace clerestory::bench {
namespace {

double residentMegabytes() {
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

double textureMegabytes(const Scene& scene) {
    double bytes = 0;
    for (const TextureImage& image : scene.images)
        bytes += static_cast<double>(image.texels.size());
    return bytes / (1024.0 * 1024.0);
}

void measure(Renderer& renderer, Scene loaded, const FrameRequest& shape, int frames) {
    const std::string id = loaded.id;
    const DefaultView view = defaultView(loaded);
    const double textures = textureMegabytes(loaded);
    renderer.addScene(std::move(loaded));
    malloc_trim(0);  // as the server does
    std::vector<double> total, processor, encode;
    std::map<std::string, std::vector<double>> passes;
    double cold = 0.0;
    PlanTotals counts;
    for (int i = -2; i < frames; ++i) {
        FrameRequest request = turned(id, view, 0.01 * i);
        request.width = shape.width;
        request.height = shape.height;
        request.accuracy = shape.accuracy;
        request.effects = shape.effects;
        if (shape.effects.indirectLight) renderer.completeLight(request);
        const double processorBefore = processorMilliseconds();
        const Stopwatch whole;
        const Frame frame = renderer.render(request);
        const Stopwatch encoding;
        const Bytes jpeg = encodeJpeg(frame.image, 85, true);
        const double encodeMs = encoding.milliseconds(), wholeMs = whole.milliseconds();
        if (i == -2) cold = wholeMs;
        if (i < 0) continue;
        total.push_back(wholeMs);
        processor.push_back(processorMilliseconds() - processorBefore);
        encode.push_back(encodeMs);
        std::map<std::string, double> kinds{{"plan", frame.planMs}, {"readback", frame.readbackMs}};
        for (const PassTime& pass : frame.passTimes) kinds[pass.kind] += pass.milliseconds;
        double known = encodeMs;
        for (const auto& [kind, ms] : kinds) {
            passes[kind].push_back(ms);
            known += ms;
        }
        passes["other"].push_back(wholeMs - known);
        counts = totals(frame.plan);
    }
    std::string parts;
    for (const auto& [kind, ms] : passes) {
        char text[64];
        std::snprintf(text, sizeof text, "%s %.1f, ", kind.c_str(), median(ms));
        parts += text;
    }
    std::printf(
        "| %s | %llu | %.1f | %.1f | %.1f | %.1f | %sencode %.1f | %.0f MB (%.0f of textures) |\n",
        id.c_str(), static_cast<unsigned long long>(counts.draws), median(total),
        percentile(total, 0.95), median(processor), cold, parts.c_str(), median(encode),
        residentMegabytes(), textures);
    renderer.removeScene(id);
}

int run(int argc, char** argv) {
    CommandLine line("What a frame costs, per pass");
    std::vector<std::string> scenes{"chapel"};
    std::string preset = "standard", effects = "all", rays = "automatic";
    int width = 1280, height = 720, frames = 15;
    line.addList("scenes", scenes, "built-in ids or files");
    line.add("--width", width);
    line.add("--height", height);
    line.add("--frames", frames, "warm frames measured");
    line.add("--accuracy", preset, "", {"draft", "standard", "fine"});
    line.add("--effects", effects,
             "none: base shading, as other renderers draw it; shadows, full: with shadows, "
             "and with light between surfaces",
             {"all", "none", "shadows", "full"});
    line.add("--rays", rays, "", {"automatic", "shader", "cpu"});
    if (const auto status = line.parse(argc, argv)) return *status;

    FrameRequest shape;
    if (effects == "none") shape.effects = {false, false, false, false, false};
    shape.effects.shadows = effects == "shadows" || effects == "full";
    shape.effects.indirectLight = effects == "full";
    shape.width = static_cast<std::uint32_t>(width);
    shape.height = static_cast<std::uint32_t>(height);
    for (const auto& [word, value] : presetChoice().words) {
        if (word == preset) shape.accuracy = accuracyOf(value);
    }
    RendererOptions options{.light = {.background = false}};
    if (rays != "automatic")
        options.rays = rays == "cpu" ? Computation::processor : Computation::shader;
    Renderer renderer(options);
    std::printf(
        "%s; %ld cores; %dx%d, accuracy %s, effects %s, rays %s, %d warm "
        "frames\n\n",
        renderer.identity().renderer.c_str(), sysconf(_SC_NPROCESSORS_ONLN), width, height,
        preset.c_str(), effects.c_str(), rays.c_str(), frames);
    std::printf(
        "| scene | draws | median ms | p95 | processor ms | cold | median ms of each part | memory "
        "|\n");
    std::printf("|---|---|---|---|---|---|---|---|\n");
    for (const std::string& name : scenes) measure(renderer, loadScene(name), shape, frames);
    return 0;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_frames", clerestory::bench::run, argc, argv);
}
