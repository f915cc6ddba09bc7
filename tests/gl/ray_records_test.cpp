// Rays that the processor follows, compared with those that the shaders follow.
#include "../support/compare_images.h"
#include "scene/builtin/builtin_scenes.h"
#include "support.h"

#include <sched.h>

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

Renderer& tracing(Computation rays) {
    static Renderer shader({.rays = Computation::shader, .debugOutput = true});
    static Renderer processor({.rays = Computation::processor, .debugOutput = true});
    Renderer& chosen = rays == Computation::shader ? shader : processor;
    for (const char* id : {"teapots", "chapel", "meadow", "six-walls"}) {
        if (!chosen.hasScene(id)) chosen.addScene(*makeBuiltinScene(id));
    }
    return chosen;
}

// Every mirror and all glass by rays; `preset` decides how many.
FrameRequest traced(const std::string& scene, Preset preset) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.scene = scene;
    r.width = 160;
    r.height = 90;
    r.accuracy = accuracyOf(preset);
    r.accuracy.samples = r.accuracy.raySamples = r.accuracy.glassRaySamples = 1;
    r.accuracy.curved = CurvedMethod::traced;
    r.accuracy.glass = GlassMethod::traced;
    r.accuracy.planar = PlanarMethod::traced;
    r.output.format = OutputFormat::npy;
    return r;
}

struct Difference {
    double relative = 0.0;  // mean of squares, relative to the first image
    double share = 0.0;     // of pixels that differ by more than 2 %
};
Difference difference(const Image& a, const Image& b) {
    Difference d;
    const double count = double(a.width) * a.height;
    for (std::uint32_t y = 0; y < a.height; ++y) {
        for (std::uint32_t x = 0; x < a.width; ++x) {
            const glm::dvec3 p(color(a, x, y)), q(color(b, x, y));
            const double error = glm::length(p - q), size = glm::length(p) + 0.05;
            d.relative += error * error / (size * size) / count;
            if (error > 0.02 * size) d.share += 1.0 / count;
        }
    }
    return d;
}

std::uint64_t paths(const Frame& frame) {
    std::uint64_t sum = 0;
    for (const PassTime& pass : frame.passTimes) sum += pass.paths;
    return sum;
}

TEST(RayRecords, AgreeWithTheShadersRays) {
    for (const char* scene : {"teapots", "chapel", "meadow"}) {
        const FrameRequest r = traced(scene, Preset::fine);
        const Frame shader = tracing(Computation::shader).render(r);
        const Frame processor = tracing(Computation::processor).render(r);
        EXPECT_EQ(paths(shader), 0u) << scene;
        EXPECT_GT(paths(processor), 100u) << scene;
        const Difference d = difference(shader.image, processor.image);
        // A ray that meets an edge may go either way; the rest differs by rounding and filtering.
        EXPECT_LT(d.share, 0.004) << scene;
        EXPECT_LT(d.relative, 1e-3) << scene;
    }
}

// Further samples have rays in chosen pixels only.
TEST(RayRecords, FurtherSamplesFollowTheRaysOfChosenPixels) {
    FrameRequest r = traced("six-walls", Preset::fine);
    r.width = 480;
    r.height = 270;
    const Frame one = tracing(Computation::processor).render(r);
    r.accuracy.samples = 4;
    const Frame four = tracing(Computation::processor).render(r);
    EXPECT_GT(paths(four), 1.5 * paths(one));
    EXPECT_LT(paths(four), 3 * paths(one)) << "in all pixels, 4 times as many";
    const Difference d = difference(tracing(Computation::shader).render(r).image, four.image);
    EXPECT_LT(d.share, 0.006);
    EXPECT_LT(d.relative, 1e-3);
    r.accuracy.sampleShare = 0.01;
    EXPECT_LT(paths(tracing(Computation::processor).render(r)), 1.2 * paths(one));
}

TEST(RayRecords, EqualRequestsGiveEqualBytes) {
    for (const Preset preset : {Preset::draft, Preset::standard}) {
        const FrameRequest r = traced("chapel", preset);
        Renderer& renderer = tracing(Computation::processor);
        const Frame first = renderer.render(r);
        renderer.render(traced("teapots", preset));
        EXPECT_EQ(renderer.render(r).image.data, first.image.data);
    }
}

TEST(RayRecords, OneThreadGivesTheBytesOfSeveral) {
    cpu_set_t all, one;
    ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
    if (CPU_COUNT(&all) < 2) GTEST_SKIP() << "needs two processors";
    CPU_ZERO(&one);
    for (int i = 0; CPU_COUNT(&one) == 0; ++i) {
        if (CPU_ISSET(i, &all)) CPU_SET(i, &one);
    }
    for (const std::uint32_t paths : {1u, 4u}) {
        FrameRequest r = traced("teapots", Preset::standard);
        r.accuracy.raySamples = r.accuracy.glassRaySamples = paths;
        Renderer& renderer = tracing(Computation::processor);
        const Frame several = renderer.render(r);
        ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
        const Frame single = renderer.render(r);
        ASSERT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
        EXPECT_EQ(single.image.data, several.image.data) << paths;
    }
}

// A rough ray has so many paths; a smooth one has one, and keeps its bytes.
TEST(RayRecords, RoughRaysHaveSeveralPaths) {
    Renderer& renderer = tracing(Computation::processor);
    FrameRequest r = traced("teapots", Preset::fine);
    for (const float roughness : {0.02f, 0.3f}) {
        r.overrides.clear();
        for (const char* metal : {"copper", "gold"}) {
            MaterialOverride change;
            change.material = metal;
            change.roughness = roughness;
            r.overrides.push_back(change);
        }
        r.effects.refraction = false;
        r.accuracy.raySamples = r.accuracy.glassRaySamples = 1;
        const Frame one = renderer.render(r);
        r.accuracy.raySamples = r.accuracy.glassRaySamples = 8;
        const Frame eight = renderer.render(r);
        ASSERT_GT(paths(one), 100u);
        if (roughness < 0.1f) {
            EXPECT_EQ(paths(eight), paths(one));
            EXPECT_EQ(eight.image.data, one.image.data);
        } else {
            EXPECT_GT(paths(eight), 6 * paths(one)) << "less what points into the surface";
            EXPECT_LE(paths(eight), 8 * paths(one));
            EXPECT_NE(eight.image.data, one.image.data);
        }
    }
}

// Fewer paths where neighbours agree, at a bounded difference from a path for every pixel.
TEST(RayRecords, PresetsFollowFewerPathsWhereNeighboursAgree) {
    Renderer& renderer = tracing(Computation::processor);
    FrameRequest r = traced("teapots", Preset::fine);
    r.width = 480;
    r.height = 270;
    const Frame all = renderer.render(r);
    r.accuracy.preset = Preset::standard;
    const Frame standard = renderer.render(r);
    r.accuracy.preset = Preset::draft;
    const Frame draft = renderer.render(r);
    EXPECT_LT(paths(standard), 0.9 * paths(all));
    EXPECT_LT(paths(draft), paths(standard));
    EXPECT_LT(difference(all.image, standard.image).relative, 2e-3);
    EXPECT_LT(difference(all.image, draft.image).relative, 1e-2);
}

// Between rays that leave the scene each pixel reads the environment in its own direction, however
// much it changes there.
TEST(RayRecords, AMirrorAloneShowsEveryDetailOfTheEnvironment) {
    Scene scene;
    scene.id = "ball alone";
    place(scene, sphere(1.0f, 48, addMaterial(scene, mirrorMetal())));
    Renderer& renderer = tracing(Computation::processor);
    renderer.addScene(std::move(scene));
    FrameRequest r = traced("ball alone", Preset::fine);
    r.environment.map = "studio";
    const Frame all = renderer.render(r);
    ASSERT_GT(paths(all), 2000u);
    for (const Preset preset : {Preset::standard, Preset::draft}) {
        r.accuracy.preset = preset;
        const Frame fewer = renderer.render(r);
        EXPECT_LT(paths(fewer), paths(all) / 6);
        EXPECT_EQ(fewer.image.data, all.image.data);
    }
}

TEST(RayRecords, ShaderProgramsHoldNoTraversal) {
    Renderer& renderer = tracing(Computation::processor);
    const FramePlan plan = renderer.plan(traced("teapots", Preset::standard));
    std::size_t recording = 0, following = 0;
    for (const Pass& pass : plan.passes) {
        const RecordedDraws* recorded = pass.recorded();
        if (recorded && !recorded->draws.empty()) ++recording;
        if (std::holds_alternative<FollowRays>(pass.work)) ++following;
        if (recorded && recorded->draws.empty()) {
            EXPECT_FALSE(followsRays(pass)) << pass.name;
        }
    }
    EXPECT_GT(recording, 0u);
    EXPECT_EQ(recording, following);
}

}  // namespace
