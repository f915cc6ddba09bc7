// Pixels with several samples: against the area that covers them, against larger pictures, and what
// stays as it is.
#include "support.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Supersampled : public GlTest {};

constexpr std::uint32_t kEdge = 64;
const glm::dmat4 kTurned = glm::rotate(glm::dmat4(1.0), 0.3, glm::dvec3(0, 0, 1));

// A white square before blackness, turned by 0.3 radians.
FrameRequest turnedSquare() {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({1, 1, 1, 1}))), kTurned);
    return request(std::move(scene), "turned square");
}

// Of the pixel that the turned square covers: 64 x 64 places.
double coveredShare(std::uint32_t x, std::uint32_t y) {
    constexpr int kPlaces = 64;
    int inside = 0;
    for (int i = 0; i < kPlaces * kPlaces; ++i) {
        // 90 degrees from a distance of 2: the picture is four metres wide.
        const double u = (x + (i % kPlaces + 0.5) / kPlaces) * 4.0 / kEdge - 2.0;
        const double v = 2.0 - (y + (i / kPlaces + 0.5) / kPlaces) * 4.0 / kEdge;
        const double across = std::cos(0.3) * u + std::sin(0.3) * v,
                     up = -std::sin(0.3) * u + std::cos(0.3) * v;
        inside += std::max(std::abs(across), std::abs(up)) <= 1.0;
    }
    return double(inside) / (kPlaces * kPlaces);
}

Image drawn(FrameRequest r, std::uint32_t samples, std::uint32_t times = 1) {
    r.width *= times;
    r.height *= times;
    r.accuracy.samples = samples;
    return renderer().render(r).image;
}

// Root mean square of the differences of square roots of red from the means of a picture that is
// eight times as large.
double differenceFromTruth(const Image& image, const Image& larger) {
    double squares = 0.0;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            double mean = 0.0;
            for (std::uint32_t i = 0; i < 64; ++i) {
                mean += color(larger, 8 * x + i % 8, 8 * y + i / 8).x / 64.0;
            }
            squares += std::pow(std::sqrt(color(image, x, y).x) - std::sqrt(mean), 2.0);
        }
    }
    return std::sqrt(squares / (double(image.width) * image.height));
}

// A wall of light and dark stripes that are not along the axes, with a frame around it that glows.
void addStripes(Scene& scene, double z, const glm::dmat4& turn = glm::dmat4(1.0)) {
    for (int i = -4; i <= 4; ++i) {
        const float light = i % 2 == 0 ? 0.8f : 0.1f;
        const Index material = addMaterial(scene, unlit({light, light, light, 1}));
        glm::dmat4 bent = moved(0.45 * i, 0, z);
        bent[1] = {0.12, 1.0, 0, 0};
        bent[0] = {0.45, 0.05, 0, 0};
        place(scene, quad(0.5f, material), turn * bent * glm::scale(glm::dmat4(1.0), {1, 6, 1}));
    }
}

}  // namespace

// The fraction of each pixel that the square covers is known. Four samples find it to a quarter;
// pixels in which they are alike have no more, the others find it to a twelfth.
TEST_F(Supersampled, EdgesShowTheCoveredArea) {
    FrameRequest r = turnedSquare();
    r.accuracy.sampleShare = 1.0;
    for (const std::uint32_t samples : {4u, 16u}) {
        const Image image = drawn(r, samples);
        std::size_t partly = 0;
        for (std::uint32_t y = 0; y < kEdge; ++y) {
            for (std::uint32_t x = 0; x < kEdge; ++x) {
                const float value = color(image, x, y).x;
                const bool isPartly = value > 0.0f && value < 1.0f;
                partly += isPartly;
                EXPECT_NEAR(value, coveredShare(x, y), isPartly && samples == 16 ? 0.09 : 0.26)
                    << x << " " << y << ", " << samples << " samples";
            }
        }
        EXPECT_GT(partly, 80u);
    }
}

// What has no contrast keeps its bytes, and at most the share that is allowed changes.
TEST_F(Supersampled, OtherPixelsKeepTheirBytes) {
    FrameRequest r = turnedSquare();
    const Image one = drawn(r, 1);
    for (const double share : {0.01, 1.0}) {
        r.accuracy.sampleShare = share;
        const Image many = drawn(r, 8);
        std::size_t changed = 0;
        for (std::uint32_t y = 1; y + 1 < kEdge; ++y) {
            for (std::uint32_t x = 1; x + 1 < kEdge; ++x) {
                const bool differs = color(one, x, y) != color(many, x, y);
                changed += differs;
                if (!differs) continue;
                bool contrast = false;
                for (std::uint32_t i = 0; i < 9; ++i) {
                    contrast |= color(one, x + i % 3 - 1, y + i / 3 - 1) != color(one, x, y);
                }
                // Very strong contrasts reach three pixels farther, where nothing is to be found.
                EXPECT_TRUE(contrast) << x << " " << y;
            }
        }
        EXPECT_LE(changed, share * kEdge * kEdge);
        EXPECT_GT(changed, share < 1.0 ? 10u : 60u);
    }
}

TEST_F(Supersampled, WithoutContrastNothingIsDrawnAgain) {
    Scene scene;
    place(scene, quad(9.0f, addMaterial(scene, unlit({0.5f, 0.5f, 0.5f, 1}))));
    FrameRequest r = request(std::move(scene), "grey");
    r.accuracy.samples = 16;
    const std::uint64_t before = renderer().counters().drawCalls;
    renderer().render(r);
    EXPECT_EQ(renderer().counters().drawCalls - before, 1u);
}

// Stripes seen directly, in a mirror, through glass, and by rays: each picture approaches that of
// eight times the size, and that of one sample is far from it.
TEST_F(Supersampled, MirrorsAndGlassAreSampledLikeSurfaces) {
    struct Case {
        const char* name;
        std::function<void(Scene&)> add;
        std::function<void(FrameRequest&)> set;
    };
    const auto ask = [](FrameRequest& r, PlanarMethod planar, GlassMethod glass) {
        r.accuracy.planar = planar;
        r.accuracy.glass = glass;
    };
    const glm::dmat4 behind =
        glm::rotate(glm::dmat4(1.0), glm::radians(180.0), glm::dvec3(0, 1, 0));
    const auto mirror = [&](Scene& scene) {
        place(scene, quad(3.0f, addMaterial(scene, mirrorMetal())));
        addStripes(scene, -3.0, behind);
    };
    const auto pane = [](Scene& scene) {
        addStripes(scene, -1.0);
        place(scene, quad(3.0f, addMaterial(scene, clearGlass())));
    };
    const Case cases[] = {
        {"directly", [](Scene& scene) { addStripes(scene, 0.0); }, [](FrameRequest&) {}},
        {"directly, from afar", [](Scene& scene) { addStripes(scene, -3.0); },
         [](FrameRequest&) {}},
        {"mirrored view", mirror,
         [&](FrameRequest& r) { ask(r, PlanarMethod::mirror, GlassMethod::automatic); }},
        {"mirror by rays", mirror,
         [&](FrameRequest& r) { ask(r, PlanarMethod::traced, GlassMethod::automatic); }},
        {"glass over a backdrop", pane,
         [&](FrameRequest& r) { ask(r, PlanarMethod::environment, GlassMethod::backdrop); }},
        {"glass by rays", pane,
         [&](FrameRequest& r) { ask(r, PlanarMethod::environment, GlassMethod::traced); }},
    };
    for (const Case& c : cases) {
        Scene scene;
        c.add(scene);
        FrameRequest r = request(std::move(scene), c.name);
        c.set(r);
        r.accuracy.sampleShare = 1.0;
        const Image truth = drawn(r, 1, 8);
        const double one = differenceFromTruth(drawn(r, 1), truth);
        const double many = differenceFromTruth(drawn(r, 16), truth);
        EXPECT_GT(one, 0.03) << c.name;
        EXPECT_LT(many, 0.4 * one) << c.name << ": " << many << " of " << one;
    }
}

// All samples of a pixel share a lobe among as many paths: one path shows a lamp in it sharply, or
// not.
TEST_F(Supersampled, LampsInRoughMirrorsStayBlurred) {
    Scene scene;
    Material metal = mirrorMetal();
    metal.roughness = 0.45f;
    place(scene, quad(3.0f, addMaterial(scene, metal)));
    for (int i = -2; i <= 2; ++i) {
        place(scene, quad(0.1f, addMaterial(scene, glowing(glm::vec3(60.0f)))),
              moved(0.8 * i, 0.3 * i, 2.6) *
                  glm::rotate(glm::dmat4(1.0), glm::radians(180.0), glm::dvec3(0, 1, 0)));
    }
    FrameRequest r = request(std::move(scene), "lamps");
    r.accuracy.planar = PlanarMethod::traced;
    r.accuracy.raySamples = 16;
    r.accuracy.sampleShare = 1.0;
    r.environment.intensity = 0.0;
    const auto brightest = [&](std::uint32_t samples) {
        const Image image = drawn(r, samples);
        float most = 0.0f;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                most = std::max(most, color(image, x, y).x);
            }
        }
        return most;
    };
    const float one = brightest(1);
    EXPECT_GT(one, 0.1f);
    EXPECT_LT(brightest(6), 1.3f * one);
}

// Before a transparent background the edge of a black thing is an edge, too.
TEST_F(Supersampled, AlphaHasContrast) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({0, 0, 0, 1}))), kTurned);
    FrameRequest r = request(std::move(scene), "black square");
    r.background = Background::transparent;
    r.accuracy.sampleShare = 1.0;
    const Image image = drawn(r, 4);
    ASSERT_EQ(image.channels, 4u);
    std::size_t partly = 0;
    for (std::size_t i = 0; i < std::size_t{kEdge} * kEdge; ++i) {
        const float alpha = image.floats()[4 * i + 3];
        partly += alpha > 0.0f && alpha < 1.0f;
    }
    EXPECT_GT(partly, 60u);
}

TEST_F(Supersampled, TheSameRequestGivesTheSameBytes) {
    FrameRequest r = turnedSquare();
    const Image first = drawn(r, 8);
    drawn(r, 3, 2);
    EXPECT_TRUE(sameBytes(drawn(r, 8), first));
}
