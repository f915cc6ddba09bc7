// Light along traced paths: furnaces, Snell's law, mirrors, and hits shaded as pixels are.
#include "../support/compare_images.h"
#include "plan/features.h"
#include "scene/builtin/builtin_scenes.h"
#include "support.h"
#include "trace_support.h"

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

constexpr std::uint32_t kSize = 64;

FrameRequest shot(const glm::dvec3& eye, const glm::dvec3& target, double yfov = 0.8) {
    FrameRequest r;
    r.width = r.height = kSize;
    r.camera.position = eye;
    r.camera.target = target;
    r.camera.yfov = yfov;
    r.output.format = OutputFormat::npy;
    r.accuracy.curved = CurvedMethod::traced;
    r.accuracy.glass = GlassMethod::traced;
    r.accuracy.planar = PlanarMethod::traced;
    return r;
}

Material mirror() {
    return {.name = "mirror", .metallic = 1.0f, .roughness = 0.0f};
}
Material glass(float ior) {
    return {.name = "glass",
            .metallic = 0.0f,
            .roughness = 0.0f,
            .ior = ior,
            .transmission = 1.0f,
            .thickness = 2.0f};
}

Scene ballScene(Material material, std::uint32_t rows = 48) {
    Scene scene;
    scene.environment = "white";
    place(scene, sphere(1.0f, rows, addMaterial(scene, std::move(material))));
    return scene;
}

bool tracesAnything(const FramePlan& plan) {
    for (const Pass& pass : plan.passes) {
        if (traces(pass)) return true;
    }
    return false;
}

void expectUniform(const Image& image, float value, float bound) {
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const glm::vec3 c = color(image, x, y);
            for (int i = 0; i < 3; ++i) ASSERT_NEAR(c[i], value, bound) << x << " " << y;
        }
    }
}

}  // namespace

TEST(TracedLight, aPerfectMirrorVanishesInAUniformEnvironment) {
    Workbench& bench = workbench();
    Scene scene = ballScene(mirror());
    // A second ball, so that paths turn more than once.
    place(scene, sphere(0.5f, 32, 0), moved(1.6, 0, 0));
    bench.show(std::move(scene));
    for (const std::uint32_t bounces : {1u, 4u}) {
        FrameRequest r = shot({0, 0, 4}, {0, 0, 0});
        r.accuracy.bounces = bounces;
        const FramePlan plan = bench.plan(r);
        ASSERT_TRUE(tracesAnything(plan)) << toText(plan);
        expectUniform(bench.run(plan), 1.0f, 2e-3f);
    }
}

TEST(TracedLight, glassThatDoesNotAbsorbVanishesInAUniformEnvironment) {
    for (const float ior : {1.0f, 1.1f, 1.5f, 2.4f}) {
        Workbench& bench = workbench();
        bench.show(ballScene(glass(ior)));
        for (const std::uint32_t bounces : {1u, 2u, 6u}) {
            SCOPED_TRACE(ior);
            FrameRequest r = shot({0, 0, 4}, {0, 0, 0});
            r.accuracy.bounces = bounces;
            const FramePlan plan = bench.plan(r);
            ASSERT_TRUE(tracesAnything(plan)) << toText(plan);
            expectUniform(bench.run(plan), 1.0f, 2e-3f);
        }
    }
}

TEST(TracedLight, theEyeInsideGlassSeesOutOrTotalReflection) {
    Workbench& bench = workbench();
    bench.show(ballScene(glass(1.5f)));
    const FramePlan plan = bench.plan(shot({0.3, 0.2, 0.4}, {1, 0, 0}, 1.5));
    expectUniform(bench.run(plan), 1.0f, 2e-3f);
}

TEST(TracedLight, absorptionFollowsThePathThroughTheBall) {
    Workbench& bench = workbench();
    Material m = glass(1.0f);
    m.attenuationColor = {0.5f, 0.25f, 1.0f};
    m.attenuationDistance = 1.0f;
    bench.show(ballScene(m, 128));
    FrameRequest r = shot({0, 0, 4}, {0, 0, 0});
    const Image image = bench.run(bench.plan(r));
    // Index 1: straight chords.
    const double focal = 0.5 * kSize / std::tan(0.4);
    for (std::uint32_t x = 0; x < kSize; ++x) {
        const double slope = (x + 0.5 - 0.5 * kSize) / focal, up = 0.5 / focal;
        const double sine2 = (slope * slope + up * up) / (1.0 + slope * slope + up * up);
        const double off = 16.0 * sine2;  // squared distance of the ray from the centre
        if (off > 0.97) continue;
        const double chord = 2.0 * std::sqrt(1.0 - off);
        const glm::vec3 c = color(image, x, kSize / 2);
        EXPECT_NEAR(c.x, std::pow(0.5, chord), 4e-3) << x;
        EXPECT_NEAR(c.y, std::pow(0.25, chord), 4e-3) << x;
        EXPECT_NEAR(c.z, 1.0, 2e-3) << x;
    }
}
