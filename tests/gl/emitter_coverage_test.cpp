// Small glowing surfaces: against the light that their area sends to the eye, and what stays as it
// is.
#include "support.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class SmallEmitters : public GlTest {};

// 90 degrees from a distance of 2: the picture is four metres wide in the plane of the origin.
constexpr double kPixel = 4.0 / 64.0;
constexpr float kRadiance = 3.0f;

// Of the red light of all pixels.
double sumOf(const Image& image) {
    double sum = 0.0;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) sum += color(image, x, y).x;
    }
    return sum;
}

glm::dmat4 turned(double angle) {
    return glm::rotate(glm::dmat4(1.0), angle, glm::dvec3(0, 0, 1));
}

// A glowing rectangle, extents in pixels, turned about its middle.
void placeEmitter(Scene& scene, const glm::dvec3& middle, const glm::dvec2& extent, double angle) {
    const glm::dmat4 scaled = glm::scale(glm::dmat4(1.0), glm::dvec3(kPixel * extent, 1.0));
    place(scene, quad(0.5f, addMaterial(scene, glowing(glm::vec3(kRadiance)))),
          moved(middle.x, middle.y, middle.z) * turned(angle) * scaled);
}

Image drawn(FrameRequest r, bool coverage = true) {
    r.accuracy.emitterCoverage = coverage;
    return renderer().render(r).image;
}

}  // namespace

// Wherever it is, an emitter sends the light of its area. One sample for each pixel misses it, or
// shows several times as much.
TEST_F(SmallEmitters, SendTheLightOfTheirArea) {
    for (const glm::dvec2 extent :
         {glm::dvec2(0.5, 0.5), glm::dvec2(1.6, 0.7), glm::dvec2(9, 0.4)}) {
        const double light = kRadiance * extent.x * extent.y;
        double least = 1e9, greatest = 0.0;
        for (int i = 0; i < 12; ++i) {
            Scene scene;
            placeEmitter(scene, {0.013 * i, -0.021 * i, 0}, extent, 0.4 * i);
            const FrameRequest r = request(std::move(scene), "emitter " + std::to_string(i));
            EXPECT_NEAR(sumOf(drawn(r)), light, 0.01 * light) << extent.x << ", place " << i;
            const double sampled = sumOf(drawn(r, false));
            least = std::min(least, sampled);
            greatest = std::max(greatest, sampled);
        }
        if (extent.x < 9) {
            EXPECT_LT(least, 0.6 * light);
            EXPECT_GT(greatest, 1.5 * light);
        }
    }
}

// Before a surface the rest of the pixel shows that surface.
TEST_F(SmallEmitters, LeaveTheRestToWhatIsBehind) {
    for (const double x : {0.0, 0.3, 0.5}) {
        Scene scene;
        place(scene, quad(9.0f, addMaterial(scene, unlit({0.5f, 0.5f, 0.5f, 1}))), moved(0, 0, -1));
        placeEmitter(scene, {x * kPixel, 0, 0}, {0.5, 20}, 0.0);
        const Image image = drawn(request(std::move(scene), "emitter before a wall"));
        double sum = 0.0;
        for (std::uint32_t column = 0; column < 64; ++column) sum += color(image, column, 32).x;
        EXPECT_NEAR(sum, 63.5 * 0.5 + 0.5 * kRadiance, 0.02) << x;
    }
}

// A wall hides them, and so does a wall with an edge next to them.
TEST_F(SmallEmitters, AreHiddenBySurfacesBeforeThem) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({0.2f, 0.2f, 0.2f, 1}))), turned(0.3));
    for (int i = -6; i <= 6; ++i) placeEmitter(scene, {0.07 * i, 0.05 * i, -0.01}, {0.5, 0.5}, i);
    const FrameRequest r = request(std::move(scene), "hidden emitters");
    EXPECT_TRUE(sameBytes(drawn(r), drawn(r, false)));
}

// Those in the plane of a wall that is seen at a small angle are not hidden by it.
TEST_F(SmallEmitters, AreSeenOnSlopingWalls) {
    Scene scene;
    const glm::dmat4 slope = glm::rotate(glm::dmat4(1.0), 1.2, glm::dvec3(1, 0, 0));
    place(scene, quad(3.0f, addMaterial(scene, unlit({0, 0, 0, 1}))), slope);
    for (int i = -3; i <= 3; ++i) {
        place(scene, quad(0.02f, addMaterial(scene, glowing(glm::vec3(kRadiance)))),
              slope * moved(0.23 * i, 0.31 * i, 1e-3));
    }
    FrameRequest r = request(std::move(scene), "emitters on a slope");
    const double light = sumOf(drawn(r));
    r.width *= 16;
    r.height *= 16;
    EXPECT_NEAR(light, sumOf(drawn(r, false)) / 256.0, 0.1 * light);
}

// A small body of many triangles covers its pixels once.
TEST_F(SmallEmitters, BodiesSendTheLightOfTheirOutline) {
    for (int i = 0; i < 6; ++i) {
        Scene scene;
        place(scene, sphere(0.05f, 24, addMaterial(scene, glowing(glm::vec3(kRadiance)))),
              moved(0.017 * i, 0.011 * i, 0));
        FrameRequest r = request(std::move(scene), "small glowing ball");
        const double light = sumOf(drawn(r));
        r.width *= 32;
        r.height *= 32;
        EXPECT_NEAR(light, sumOf(drawn(r, false)) / 1024.0, 0.01 * light) << i;
    }
}

// Seen in a mirror, or behind glass that bends nothing, they are what they are without.
TEST_F(SmallEmitters, AreSeenInMirrorsAndThroughGlass) {
    for (const bool inMirror : {true, false}) {
        Scene scene;
        const double z = inMirror ? 4.0 : -4.0;
        for (int i = -3; i <= 3; ++i) placeEmitter(scene, {0.9 * i, 0.41 * i, z}, {1.1, 1.7}, i);
        if (inMirror) {
            place(scene, quad(1.9f, addMaterial(scene, mirrorMetal())));
        } else {
            place(scene, quad(1.9f, addMaterial(scene, clearGlass(1.0f))));
        }
        FrameRequest r = request(std::move(scene), inMirror ? "in a mirror" : "behind glass");
        r.accuracy.planar = PlanarMethod::mirror;
        r.accuracy.glass = GlassMethod::backdrop;
        const double light = sumOf(drawn(r));
        r.width *= 16;
        r.height *= 16;
        const double truth = sumOf(drawn(r, false)) / 256.0;
        EXPECT_GT(truth, 1.0);
        EXPECT_NEAR(light, truth, 0.02 * truth) << (inMirror ? "in a mirror" : "behind glass");
    }
}

TEST_F(SmallEmitters, AreInTheAlphaOfTransparentPictures) {
    Scene scene;
    placeEmitter(scene, {0.02, 0.02, 0}, {0.5, 0.5}, 0.2);
    FrameRequest r = request(std::move(scene), "emitter before nothing");
    r.background = Background::transparent;
    const Image image = drawn(r);
    ASSERT_EQ(image.channels, 4u);
    double alpha = 0.0, red = 0.0;
    for (std::size_t i = 0; i < std::size_t{64} * 64; ++i) {
        red += image.floats()[4 * i];
        alpha += image.floats()[4 * i + 3];
    }
    EXPECT_NEAR(alpha, 0.25, 0.003);
    EXPECT_NEAR(red, kRadiance * alpha, 0.02);
}

// The sum of several emitters in a pixel is finite, however bright they are.
TEST_F(SmallEmitters, StayFinite) {
    Scene scene;
    for (int i = -5; i <= 5; ++i) {
        Material light = glowing(glm::vec3(1e4f));
        light.emissiveStrength = 1e4f;
        place(scene, quad(0.01f, addMaterial(scene, light)), moved(0.021 * i, 0.013 * i, 0.01 * i));
    }
    const Image image = drawn(request(std::move(scene), "very bright emitters"));
    EXPECT_GT(sumOf(image), 100.0);
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            EXPECT_LE(color(image, x, y).x, 65504.0f) << x << " " << y;
        }
    }
}

// What fills a pixel or does not glow is drawn as before.
TEST_F(SmallEmitters, OtherSurfacesKeepTheirBytes) {
    struct Case {
        const char* name;
        MeshDraft (*draft)(Index material);
        Material material;
    };
    const Material light = glowing(glm::vec3(1.0f));
    const Case cases[] = {
        {"large triangles", [](Index m) { return quad(1.9f, m); }, light},
        {"a ball", [](Index m) { return sphere(0.3f, 24, m); }, light},
        {"a strip", [](Index m) { return quad(0.14f, m); }, light},
        {"no emitter", [](Index m) { return quad(0.03f, m); }, lambert(0.5f)},
    };
    for (const Case& c : cases) {
        Scene scene;
        place(scene, c.draft(addMaterial(scene, c.material)), turned(0.3));
        const FrameRequest r = request(std::move(scene), c.name);
        EXPECT_TRUE(sameBytes(drawn(r), drawn(r, false))) << c.name;
    }
}
