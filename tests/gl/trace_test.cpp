// Rays compared with rasterisation.
#include "scene/builtin/builtin_scenes.h"
#include "scene/default_view.h"
#include "scene/import/in_process.h"
#include "support.h"
#include "trace_support.h"

#include <cmath>
#include <filesystem>

using namespace clerestory;
using namespace clerestory::test;

namespace {

FrameRequest looking(const Scene& scene, Channel channel, std::uint32_t width = 320,
                     std::uint32_t height = 180) {
    const DefaultView view = defaultView(scene);
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.width = width;
    r.height = height;
    r.camera.position = view.position;
    r.camera.target = view.target;
    r.camera.yfov = view.yfov;
    r.output.format = OutputFormat::npy;
    r.output.channel = channel;
    return r;
}

// Share of pixels that differ by more than `bound` of the value (absolute below 1).
double shareOver(const Image& a, const Image& b, double bound) {
    EXPECT_EQ(a.channels, b.channels);
    std::size_t over = 0;
    const std::size_t pixels = std::size_t{a.width} * a.height;
    for (std::size_t i = 0; i < pixels; ++i) {
        bool differs = false;
        for (std::uint32_t c = 0; c < a.channels; ++c) {
            const double x = a.floats()[i * a.channels + c], y = b.floats()[i * a.channels + c];
            differs |= !(std::abs(x - y) <= bound * std::max(1.0, std::abs(y)));
        }
        over += differs;
    }
    return static_cast<double>(over) / static_cast<double>(pixels);
}

void expectRaysSeeWhatIsDrawn(Scene scene) {
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    for (const Channel channel : {Channel::depth, Channel::objectId, Channel::normal}) {
        const FramePlan plan = bench.plan(looking(bench.scene(), channel));
        const Image drawn = bench.run(plan), traced = bench.traced(plan);
        // Graphics cards interpolate texels, here those of normal maps, with weights of 8 bits.
        const double bound = channel != Channel::normal                       ? 2e-4
                             : gl::Context::current().capabilities().software ? 2e-3
                                                                              : 1.0 / 128;
        // Pixels whose centre lies on an edge may fall to either side.
        EXPECT_LE(shareOver(traced, drawn, bound), 1e-3) << static_cast<int>(channel);
    }
}

std::optional<Scene> shared(const std::string& path) {
    const std::filesystem::path file = std::filesystem::path(CLERESTORY_SHARED_SCENES) / path;
    if (!std::filesystem::exists(file)) return std::nullopt;
    return importSceneInProcess(file);
}

}  // namespace

TEST(Traced, IsAvailable) {
    workbench();
    EXPECT_TRUE(GpuTracer::supported());
}

TEST(Traced, PrimaryRaysSeeTheSixWallsAsDrawn) {
    expectRaysSeeWhatIsDrawn(*makeBuiltinScene("six-walls"));
}

TEST(Traced, PrimaryRaysSeeTheChapelAsDrawn) {
    expectRaysSeeWhatIsDrawn(*makeBuiltinScene("chapel"));
}

TEST(Traced, PrimaryRaysSeeSponzaAsDrawn) {
    std::optional<Scene> scene = shared("Sponza/Sponza.gltf");
    if (!scene) GTEST_SKIP() << "no shared scenes";
    expectRaysSeeWhatIsDrawn(std::move(*scene));
}
