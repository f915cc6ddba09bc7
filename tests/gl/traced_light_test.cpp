// Light along traced paths: furnaces, Snell's law, mirrors, and shading of hits.
#include "../support/compare_images.h"
#include "plan/graph/features.h"
#include "scene/builtin/builtin_scenes.h"
#include "scene/default_view.h"
#include "support.h"
#include "trace_support.h"

#include <algorithm>
#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

constexpr std::uint32_t kSize = 64;

FrameRequest shot(const glm::dvec3& eye, const glm::dvec3& target, double yfov = 0.8) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
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

void expectUniform(const Image& image, float value, float bound) {
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const glm::vec3 c = color(image, x, y);
            for (int i = 0; i < 3; ++i) ASSERT_NEAR(c[i], value, bound) << x << " " << y;
        }
    }
}

}  // namespace

TEST(TracedLight, APerfectMirrorVanishesInAUniformEnvironment) {
    PlanRunner& bench = workbench();
    Scene scene = ballScene(mirrorMetal());
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

TEST(TracedLight, GlassThatDoesNotAbsorbVanishesInAUniformEnvironment) {
    for (const float ior : {1.0f, 1.1f, 1.5f, 2.4f}) {
        PlanRunner& bench = workbench();
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

TEST(TracedLight, EyesInsideGlassSeeRefractionOrTotalReflection) {
    PlanRunner& bench = workbench();
    bench.show(ballScene(glass(1.5f)));
    const FramePlan plan = bench.plan(shot({0.3, 0.2, 0.4}, {1, 0, 0}, 1.5));
    expectUniform(bench.run(plan), 1.0f, 2e-3f);
}

TEST(TracedLight, AbsorptionFollowsThePathThroughTheBall) {
    PlanRunner& bench = workbench();
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

namespace {

// Unlit squares about the origin, turned inwards, each of one colour: +X -X +Y -Y +Z -Z.
const std::array<glm::vec3, 6> kWallColors = {glm::vec3(1, 0, 0), glm::vec3(0, 1, 1),
                                              glm::vec3(0, 1, 0), glm::vec3(1, 0, 1),
                                              glm::vec3(0, 0, 1), glm::vec3(1, 1, 0)};
void addWalls(Scene& scene, double distance) {
    for (int i = 0; i < 6; ++i) {
        Material m{.baseColor = glm::vec4(kWallColors[i], 1.0f), .unlit = true};
        const int axis = i / 2;
        const double side = i % 2 == 0 ? 1.0 : -1.0;
        glm::dmat4 wall(0.0);  // z towards the middle
        wall[2][axis] = -side;
        wall[0][(axis + 1) % 3] = 1.0;
        const glm::dvec3 up = glm::cross(glm::dvec3(wall[2]), glm::dvec3(wall[0]));
        wall[1] = glm::dvec4(up, 0.0);
        wall[3][axis] = side * distance;
        wall[3][3] = 1.0;
        place(scene, quad(static_cast<float>(distance), addMaterial(scene, m)), wall);
    }
}

glm::dvec3 pixelRay(std::uint32_t x, std::uint32_t y, double yfov) {
    const double k = 2.0 * std::tan(0.5 * yfov) / kSize;
    return glm::normalize(glm::dvec3((x + 0.5 - 0.5 * kSize) * k, (0.5 * kSize - y - 0.5) * k, -1));
}

// Unpolarised, of one interface from outside.
double fresnelOnce(double cosine, double ior) {
    const double inner = std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
    const double s = (cosine - ior * inner) / (cosine + ior * inner);
    const double p = (ior * cosine - inner) / (ior * cosine + inner);
    return 0.5 * (s * s + p * p);
}

// The first intersection of a ray with the ball of radius 1 around the origin.
std::optional<glm::dvec3> onBall(const glm::dvec3& eye, const glm::dvec3& d) {
    const double b = glm::dot(eye, d), c = glm::dot(eye, eye) - 1.0, root = b * b - c;
    if (root < 0.0) return std::nullopt;
    return eye + d * (-b - std::sqrt(root));
}

}  // namespace

TEST(TracedLight, MirrorBallsShowWallsAtTheirReflectedPositions) {
    Scene scene;
    scene.environment = "black";
    addWalls(scene, 5.0);
    place(scene, sphere(1.0f, 96, addMaterial(scene, mirrorMetal())));
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    const glm::dvec3 eye(0.3, 0.4, 3.5);
    FrameRequest r = shot(eye, eye - glm::dvec3(0, 0, 1));
    const Image image = bench.run(bench.plan(r));
    std::array<int, 6> seen{};
    for (std::uint32_t y = 0; y < kSize; ++y) {
        for (std::uint32_t x = 0; x < kSize; ++x) {
            const glm::dvec3 d = pixelRay(x, y, 0.8);
            const auto p = onBall(eye, d);
            if (!p || glm::dot(*p, -d) < 0.1) continue;  // the rim falls to either side
            const glm::dvec3 mirrored = glm::reflect(d, *p);
            // The wall that the ray reaches first, and how clear that is.
            std::array<double, 3> t{};
            for (int axis = 0; axis < 3; ++axis) {
                t[axis] = (std::copysign(5.0, mirrored[axis]) - (*p)[axis]) / mirrored[axis];
            }
            const int axis = static_cast<int>(std::min_element(t.begin(), t.end()) - t.begin());
            std::sort(t.begin(), t.end());
            if (t[1] - t[0] < 0.05 * t[0]) continue;  // near the walls' edge
            const int wall = 2 * axis + (mirrored[axis] > 0.0 ? 0 : 1);
            ++seen[wall];
            const glm::vec3 c = color(image, x, y);
            for (int i = 0; i < 3; ++i) {
                ASSERT_NEAR(c[i], kWallColors[wall][i], 2e-3) << x << " " << y;
            }
        }
    }
    for (int wall = 0; wall < 5; ++wall) EXPECT_GT(seen[wall], 3) << wall;
}

TEST(TracedLight, GlassBallsRefractBySnell) {
    // Behind the ball a wall whose colour encodes the position.
    constexpr float kHalf = 60.0f, kBehind = 30.0f;
    Scene scene;
    scene.environment = "black";
    MeshDraft wall = quad(kHalf, addMaterial(scene, {.unlit = true}));
    for (Vertex& v : wall.vertices) {
        v.color = glm::vec4(0.5f + 0.5f * v.position.x / kHalf, 0.5f + 0.5f * v.position.y / kHalf,
                            0.0f, 1.0f);
    }
    place(scene, std::move(wall), moved(0, 0, -kBehind));
    constexpr float kIor = 1.5f;
    place(scene, sphere(1.0f, 160, addMaterial(scene, glass(kIor))));
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    const glm::dvec3 eye(0, 0, 10);
    constexpr double kYfov = 0.22;
    const Image image = bench.run(bench.plan(shot(eye, {0, 0, 0}, kYfov)));
    int compared = 0;
    for (std::uint32_t y = 0; y < kSize; ++y) {
        for (std::uint32_t x = 0; x < kSize; ++x) {
            const glm::dvec3 d = pixelRay(x, y, kYfov);
            const auto p = onBall(eye, d);
            if (!p) continue;
            const double cosine = -glm::dot(*p, d);
            if (cosine < 0.72) continue;  // then the mirrored ray meets the wall, too
            const glm::dvec3 inside = glm::refract(d, *p, 1.0 / double{kIor});
            const glm::dvec3 q = *p - 2.0 * glm::dot(inside, *p) * inside;
            const glm::dvec3 out = glm::refract(inside, -q, double{kIor});
            // The textbook's figure, to be sure of the line above.
            const double theta = std::acos(cosine), inner = std::asin(std::sin(theta) / kIor);
            ASSERT_NEAR(std::acos(std::min(1.0, glm::dot(out, d))), 2.0 * (theta - inner), 1e-6);

            // Light reflected internally at the exit counts as if it left there, as for glass over
            // a backdrop.
            const double through = 1.0 - fresnelOnce(cosine, kIor);
            const glm::vec3 c = color(image, x, y) / static_cast<float>(through);
            const glm::dvec3 there((double{c.x} - 0.5) * 2.0 * kHalf,
                                   (double{c.y} - 0.5) * 2.0 * kHalf, -kBehind);
            const double cosineOff = glm::dot(glm::normalize(there - q), out);
            const double degrees = std::acos(std::min(1.0, cosineOff)) * 57.29577951;
            ASSERT_LT(degrees, 0.2) << x << " " << y;
            ++compared;
        }
    }
    EXPECT_GT(compared, 700);
}

// Where one sample shows an even colour all around, four must show it, too: no grid of the mesh.
TEST(TracedLight, FourSamplesShowNoGridPattern) {
    Scene scene;
    scene.environment = "black";
    addWalls(scene, 5.0);
    Material tinted = glass(1.5f);
    tinted.baseColor = {0.3f, 0.3f, 0.3f, 1.0f};  // what enters twice is much darker
    place(scene, sphere(1.0f, 24, addMaterial(scene, tinted)));
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    FrameRequest r = shot({0.3, 0.4, 3.0}, {0, 0, 0});
    const Image one = bench.run(bench.plan(r));
    r.accuracy.samples = 4;
    const FramePlan plan = bench.plan(r);
    const Image four = bench.run(plan);
    int even = 0;
    for (std::uint32_t y = 1; y + 1 < kSize; ++y) {
        for (std::uint32_t x = 1; x + 1 < kSize; ++x) {
            double around = 0.0;
            for (std::uint32_t k = 0; k < 9; ++k) {
                const glm::vec3 off = color(one, x + k % 3 - 1, y + k / 3 - 1) - color(one, x, y);
                around = std::max(around, double(std::sqrt(glm::dot(off, off))));
            }
            if (around > 0.05) continue;
            ++even;
            const glm::vec3 off = color(four, x, y) - color(one, x, y);
            EXPECT_LT(std::sqrt(glm::dot(off, off)), 0.05) << x << " " << y;
        }
    }
    EXPECT_GT(even, 1500);
}

// A lamp's highlight on what a curved mirror shows is far smaller than a pixel there: a point of it
// would flicker or be missed. The brightest pixel is compared with averages of 8 by 8 pixels of a
// finer picture.
TEST(TracedLight, HighlightsInCurvedMirrorsAreStable) {
    Scene scene;
    scene.environment = "black";
    place(scene, sphere(1.0f, 48, addMaterial(scene, mirrorMetal())));
    Material glossy{.metallic = 1.0f, .roughness = 0.15f};
    glossy.reflection = Reflection::none;
    const Index gloss = addMaterial(scene, glossy);
    for (int i = 0; i < 12; ++i) {
        const double angle = 0.5236 * i;
        place(scene, sphere(0.3f, 24, gloss),
              moved(1.9 * std::cos(angle), 1.9 * std::sin(angle), 0.8));
    }
    addLight(scene, {.kind = LightKind::point, .intensity = glm::vec3(20.0f)}, moved(0, 0.5, 6));
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    FrameRequest r = shot({0, 0, 6}, {0, 0, 0}, 0.33);  // the mirror alone
    const Image coarse = bench.run(bench.plan(r));
    r.width = r.height = 8 * kSize;
    const Image fine = bench.run(bench.plan(r));
    double flash = 0.0, brightest = 0.0;  // greatest of a pixel, and of 8 by 8
    for (std::uint32_t y = 0; y < kSize; ++y) {
        for (std::uint32_t x = 0; x < kSize; ++x) {
            // There the lamp stands in the mirror itself.
            if (std::hypot(x - 0.5 * kSize, y - 0.5 * kSize) < 0.15 * kSize) continue;
            double sum = 0.0;
            for (std::uint32_t k = 0; k < 64; ++k) {
                sum += double{color(fine, 8 * x + k % 8, 8 * y + k / 8).g} / 64.0;
            }
            brightest = std::max(brightest, sum);
            flash = std::max(flash, double{color(coarse, x, y).g});
        }
    }
    EXPECT_GT(brightest, 0.1);
    EXPECT_NEAR(flash / brightest, 1.0, 0.5);
}

namespace {

// A flat mirror before the scene's own camera, rotated so that it shows objects next to it.
FrameRequest withMirror(Scene& scene) {
    for (Material& m : scene.materials) m.reflection = Reflection::none;
    const DefaultView view = defaultView(scene);
    const glm::dvec3 forward = glm::normalize(view.target - view.position);
    const glm::dvec3 side = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0)));
    const double far = 0.06 * double{worldBounds(scene, poseAt(scene, 0.0)).diagonal()};
    const glm::dvec3 normal = glm::normalize(-forward + 0.35 * side);
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), normal));
    const glm::dmat4 place4(glm::dvec4(right, 0), glm::dvec4(glm::cross(normal, right), 0),
                            glm::dvec4(normal, 0), glm::dvec4(view.position + far * forward, 1));
    place(scene, quad(static_cast<float>(0.4 * far), addMaterial(scene, mirrorMetal())), place4);
    FrameRequest r = shot(view.position, view.target, view.yfov);
    r.width = 320;
    r.height = 240;
    r.output.format = OutputFormat::png;
    r.accuracy.edgeFilter = false;
    r.accuracy.curved = CurvedMethod::environment;
    r.accuracy.glass = GlassMethod::environment;
    r.effects.refraction = false;
    return r;
}

void expectTracedMirrorAsDrawn(const char* name) {
    Scene scene = *makeBuiltinScene(name);
    FrameRequest r = withMirror(scene);
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    r.accuracy.generations = 1;
    const FramePlan traced = bench.plan(r);
    ASSERT_TRUE(tracesAnything(traced)) << toText(traced);
    r.accuracy.planar = PlanarMethod::mirror;
    const FramePlan drawn = bench.plan(r);
    EXPECT_FALSE(tracesAnything(drawn));
    const Image actual = bench.run(traced), expected = bench.run(drawn);
    EXPECT_TRUE(imagesMatch(actual, expected, kEdges));
}

}  // namespace

TEST(TracedLight, TracedFlatMirrorsMatchMirroredViewsInTheSixWalls) {
    expectTracedMirrorAsDrawn("six-walls");
}

TEST(TracedLight, TracedFlatMirrorsMatchMirroredViewsInTheChapel) {
    expectTracedMirrorAsDrawn("chapel");
}
