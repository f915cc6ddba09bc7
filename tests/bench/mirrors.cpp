// `bench_mirrors [--faces N] [--frames N]`: five to eight mirror balls in a room, each with its own
// captured cube, redrawn in every frame with one to three generations: a 4 x 3 table. Exits with 1
// if the number of face views does not grow as expected.
#include "command_line.h"
#include "program.h"
#include "renderer.h"
#include "scene/builtin/modelling.h"
#include "statistics.h"

#include <unistd.h>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cstdio>

namespace clerestory::bench {
namespace {

constexpr double kHalfRoom = 3.0;  // metres
constexpr double kRing = 1.8;      // radius of the circle on which the balls stand
constexpr float kBall = 0.5f;
constexpr int kSegments = 48;

Scene roomOf(int balls) {
    Scene scene;
    scene.id = "mirrors" + std::to_string(balls);
    scene.environment = "studio";
    const auto material = [&](Material m) {
        scene.materials.push_back(std::move(m));
        return static_cast<Index>(scene.materials.size() - 1);
    };
    const auto h = static_cast<float>(kHalfRoom);
    for (int side = 0; side < 6; ++side) {
        const glm::vec4 color(0.3f + 0.12f * float(side), 0.8f - 0.1f * float(side),
                              0.4f + 0.1f * float(side % 3), 1.0f);
        MeshDraft wall = shapes::draft("wall", material({.name = "wall " + std::to_string(side),
                                                         .baseColor = color,
                                                         .metallic = 0.0f,
                                                         .roughness = 0.9f}));
        glm::vec3 corner(-h), u(0.0f), v(0.0f);
        corner[side / 2] = side % 2 == 0 ? -h : h;
        u[(side / 2 + (side % 2 == 0 ? 1 : 2)) % 3] = 2.0f * h;  // the front faces inwards
        v[(side / 2 + (side % 2 == 0 ? 2 : 1)) % 3] = 2.0f * h;
        shapes::addPatch(wall, corner, u, v);
        shapes::addToScene(scene, std::move(wall));
    }
    const Index lampNode = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {0.0, 2.5, 0.0}));
    scene.lights.push_back({.name = "lamp", .node = lampNode, .intensity = glm::vec3(20.0f)});
    const Index silver = material({.name = "silver", .metallic = 1.0f, .roughness = 0.0f});
    for (int i = 0; i < balls; ++i) {
        const double angle = glm::two_pi<double>() * i / balls;
        const glm::dvec3 at(kRing * std::sin(angle), 0.4 * (i % 2) - 0.2, kRing * std::cos(angle));
        MeshDraft ball = shapes::draft("ball " + std::to_string(i), silver);
        shapes::addSphere(ball, {}, kBall, kSegments);
        shapes::addToScene(scene, std::move(ball), glm::translate(glm::dmat4(1.0), at));
    }
    scene.defaultView = DefaultView{{0.0, 1.4, 2.9}, {0.0, -0.2, 0.0}, 1.2};
    updateContentHash(scene);
    return scene;
}

FrameRequest requestFor(int balls, std::uint32_t generations, std::uint32_t faces) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.scene = "mirrors" + std::to_string(balls);
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.probeSamples = 1;
    r.accuracy.probeSize = faces;
    r.accuracy.generations = generations;
    return r;
}

struct Cell {
    double median = 0.0, p95 = 0.0, processor = 0.0;
    std::size_t faceViews = 0;
    std::uint64_t triangles = 0;
};

Cell measure(Renderer& renderer, FrameRequest request, int frames) {
    std::vector<double> wall, processor;
    Cell cell;
    for (int i = -1; i < frames; ++i) {
        renderer.forgetMaps();
        request.exposure = 0.01 * i;  // no two frames alike
        const double before = processorMilliseconds();
        const Stopwatch watch;
        const Frame frame = renderer.render(request);
        if (i >= 0) {
            wall.push_back(watch.milliseconds());
            processor.push_back(processorMilliseconds() - before);
        }
        cell.faceViews = static_cast<std::size_t>(
            std::count_if(frame.plan.passes.begin(), frame.plan.passes.end(),
                          [](const Pass& p) { return p.kind() == "capture"; }));
        cell.triangles = totals(frame.plan).triangles;
    }
    cell.median = median(wall);
    cell.p95 = percentile(wall, 0.95);
    cell.processor = median(processor);
    return cell;
}

int run(int argc, char** argv) {
    CommandLine line("Mirrored balls that see each other");
    std::uint32_t faces = 1024;
    int frames = 3;
    line.add("--faces", faces, "texels along the edge of a cube's face", {16, 2048});
    line.add("--frames", frames, "frames measured for each cell", {1, 1000});
    if (const auto status = line.parse(argc, argv)) return *status;

    Renderer renderer{RendererOptions{}};
    std::printf(
        "%s; %ld cores, load average %.1f; %u x %u faces, 1280x720, %d frames each, "
        "everything redrawn\n\n",
        renderer.identity().renderer.c_str(), sysconf(_SC_NPROCESSORS_ONLN), loadAverage(), faces,
        faces, frames);
    std::printf(
        "| mirrors | generations | median ms | p95 | processor ms | face views | "
        "triangles |\n|---|---|---|---|---|---|---|\n");
    bool grows = true;
    for (int balls = 5; balls <= 8; ++balls) {
        renderer.addScene(roomOf(balls));
        for (std::uint32_t generations = 1; generations <= 3; ++generations) {
            const Cell cell = measure(renderer, requestFor(balls, generations, faces), frames);
            std::printf("| %d | %u | %.0f | %.0f | %.0f | %zu | %llu |\n", balls, generations,
                        cell.median, cell.p95, cell.processor, cell.faceViews,
                        static_cast<unsigned long long>(cell.triangles));
            std::fflush(stdout);
            grows &= cell.faceViews == 6u * static_cast<std::size_t>(balls) * generations;
        }
        renderer.removeScene("mirrors" + std::to_string(balls));
    }
    std::printf("\n%s\nLoad average at the end %.1f\n",
                grows ? "Six face views for each mirror and generation, as it must be."
                      : "WRONG: not six face views for each mirror and generation.",
                loadAverage());
    return grows ? 0 : 1;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_mirrors", clerestory::bench::run, argc, argv);
}
