// Captured cubes compared with arithmetic in a room of known walls and with ordinary cameras, and
// their cost.
#include "room.h"
#include "six_pictures.h"

#include <glm/gtc/matrix_transform.hpp>

#include <set>

namespace clerestory::test {
namespace {

class Probes : public GlTest {};

Material silver(float reflectance = 1.0f, float roughness = 0.0f) {
    return {.name = "silver",
            .baseColor = glm::vec4(glm::vec3(reflectance), 1.0f),
            .metallic = 1.0f,
            .roughness = roughness,
            .reflection = Reflection::mirror};  // at any roughness
}

void forceProbes(FrameRequest& r) {
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.parallax = Parallax::box;
}

FrameRequest lookingAt(Scene scene, const std::string& id, const glm::dvec3& eye,
                       const glm::dvec3& target, std::uint32_t size = 128) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.camera.target = target;
    r.camera.yfov = 0.6;
    r.width = r.height = size;
    forceProbes(r);
    return r;
}

const glm::dvec3 kEyes[] = {{0.1, 0.2, 2.9},  {2.9, 0.1, 0.2},  {0.2, 2.9, 0.1},
                            {0.2, 0.1, -2.9}, {-2.9, 0.1, 0.2}, {0.1, -2.9, 0.2}};

// With the box as proxy, every pixel of the ball is predictable for any position of eye and ball.
TEST_F(Probes, ShowEachWallAtItsReflectedPosition) {
    const Room room;
    const glm::dvec3 center(0.3, -0.2, 0.4);
    std::set<float> seenColors;
    Scene scene;
    room.build(scene);
    place(scene, sphere(0.5f, 96, addMaterial(scene, silver())),
          glm::translate(glm::dmat4(1.0), center));
    FrameRequest r = lookingAt(std::move(scene), "six walls", kEyes[0], center);
    for (const glm::dvec3& eye : kEyes) {
        r.camera.position = eye;
        const Image image = renderer().render(r).image;
        int compared = 0, off = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, center, 0.5);
                // At the silhouette the flat triangles are visible.
                if (!t || !meetsBall(ray, center, 0.48)) continue;
                const glm::dvec3 p = ray.origin + *t * ray.direction;
                const glm::dvec3 n = (p - center) / 0.5;
                const Ray mirrored{p, glm::reflect(ray.direction, n)};
                double margin = 0.0;
                const glm::vec3 expected = room.radianceAt(
                    leavesBox(mirrored, glm::dvec3(-kRoom), glm::dvec3(kRoom)), margin);
                if (margin < 0.1) continue;  // three texels of the cube's at the walls' ends
                ++compared;
                off += greatestDifference(color(image, x, y), expected) > 0.005;
                seenColors.insert(expected.x + 10.0f * expected.y + 100.0f * expected.z);
            }
        }
        EXPECT_GT(compared, 2000);
        EXPECT_EQ(off, 0) << "of " << compared << " seen from " << eye.x << ' ' << eye.y << ' '
                          << eye.z;
    }
    EXPECT_EQ(seenColors.size(), 24u);
}

// Two ways to one mirror: a metal, and a dielectric whose specular colour is that bright.
TEST_F(Probes, BrightDielectricsMirrorAsMetals) {
    const auto drawn = [](const Material& material, CurvedMethod method) {
        Scene scene;
        Room{}.build(scene);
        place(scene, sphere(0.5f, 48, addMaterial(scene, material)), moved(0.3, -0.2, 0.4));
        FrameRequest r =
            lookingAt(std::move(scene), "bright ball", {0.1, 0.2, 2.9}, {0.3, -0.2, 0.4});
        r.accuracy.curved = method;
        return renderer().render(r).image;
    };
    const Material dielectric{.baseColor = {0, 0, 0, 1},
                              .metallic = 0.0f,
                              .roughness = 0.0f,
                              .specularColor = glm::vec3(25.0f)};
    for (const CurvedMethod method : {CurvedMethod::automatic, CurvedMethod::probe}) {
        const Image metal = drawn(silver(), method), bright = drawn(dielectric, method);
        double greatest = 0.0;
        for (std::uint32_t y = 0; y < metal.height; ++y) {
            for (std::uint32_t x = 0; x < metal.width; ++x) {
                greatest =
                    std::max(greatest, greatestDifference(color(metal, x, y), color(bright, x, y)));
            }
        }
        EXPECT_LT(greatest, 0.01);
    }
}

// Two ways to one picture: what a mirror ball shows along a direction, and what a camera of 90
// degrees in its middle sees there.
TEST_F(Probes, EqualSixOrdinaryCameras) {
    const glm::dvec3 center(0.2, 0.1, -0.3);
    const auto surroundings = [] {
        Scene scene;
        Room{}.build(scene);
        Material paint{.baseColor = {0.7f, 0.5f, 0.2f, 1}, .metallic = 0.0f, .specular = 0.0f};
        place(scene, sphere(0.4f, 16, addMaterial(scene, paint)), moved(1.5, 0.8, -1.2));
        place(scene, quad(0.5f, addMaterial(scene, paint)), moved(-1, -0.5, -2));
        return scene;
    };
    FrameRequest direct = request(surroundings(), "direct", center);
    direct.width = direct.height = 256;
    direct.environment.map = "white";  // lights the paint; no lamps, which a mirror shows by itself
    const SixPictures around(direct, center);

    Scene scene = surroundings();
    place(scene, sphere(0.02f, 96, addMaterial(scene, silver())),
          glm::translate(glm::dmat4(1.0), center));
    FrameRequest r = lookingAt(std::move(scene), "ball", center, center);
    r.environment.map = "white";
    r.accuracy.parallax = Parallax::none;
    for (const glm::dvec3& from : kEyes) {
        r.camera.position = center + 0.03 * from;
        const Image image = renderer().render(r).image;
        int compared = 0, off = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, center, 0.02);
                if (!t || !meetsBall(ray, center, 0.019)) continue;
                const glm::dvec3 n = glm::normalize(ray.origin + *t * ray.direction - center);
                const auto expected = around.along(glm::reflect(ray.direction, n));
                if (!expected) continue;
                ++compared;
                off += greatestDifference(color(image, x, y), *expected) > 0.02;
            }
        }
        EXPECT_GT(compared, 1500);
        EXPECT_EQ(off, 0) << "of " << compared;
    }
}

// The pixels of the ball, well within its silhouette.
std::vector<glm::vec3> ballPixels(const FrameRequest& r, const glm::dvec3& center, double radius) {
    const Image image = renderer().render(r).image;
    std::vector<glm::vec3> pixels;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            if (meetsBall(sightOfPixel(r, x, y), center, 0.96 * radius)) {
                pixels.push_back(color(image, x, y));
            }
        }
    }
    return pixels;
}

// A box, or the probe's own depth, moves what stands near; the sky is equally far from everywhere.
TEST_F(Probes, ShowTheSkyIndependentOfParallax) {
    Scene scene;
    scene.environment = "sky";
    place(scene, sphere(1.0f, 64, addMaterial(scene, silver())));
    glm::dmat4 floor = moved(0.0, -1.5, 0.0);
    floor[1] = {0.0, 0.0, -1.0, 0.0};  // faces up
    floor[2] = {0.0, 1.0, 0.0, 0.0};
    place(scene, quad(8.0f, addMaterial(scene, unlit(glm::vec4(1.0f)))), floor);
    FrameRequest r = lookingAt(std::move(scene), "open", {0.0, 0.5, 4.0}, {0, 0, 0});
    r.environment.map = "sky";
    r.accuracy.parallax = Parallax::none;
    const Image still = renderer().render(r).image;
    for (const Parallax parallax : {Parallax::box, Parallax::depth}) {
        r.accuracy.parallax = parallax;
        const Image image = renderer().render(r).image;
        int compared = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const Ray ray = sightOfPixel(r, x, y);
                const auto t = meetsBall(ray, {0, 0, 0}, 1.0);
                if (!t) continue;
                const glm::dvec3 normal = ray.origin + *t * ray.direction;
                if (glm::reflect(ray.direction, normal).y < 0.15) continue;
                ++compared;
                const double off = greatestDifference(color(image, x, y), color(still, x, y));
                ASSERT_LT(off, 1e-3) << x << " " << y;
            }
        }
        EXPECT_GT(compared, 1000);
    }
}

TEST_F(Probes, HaveNoSeamsInConstantSurroundings) {
    for (int step = 0; step <= 10; ++step) {
        const float roughness = 0.1f * float(step);
        Scene scene;
        Room{glm::vec3(0.5f)}.build(scene);
        place(scene, sphere(0.5f, 64, addMaterial(scene, silver(1.0f, roughness))));
        FrameRequest r = lookingAt(std::move(scene), "one colour", kEyes[0], {0, 0, 0});
        for (const glm::vec3& pixel : ballPixels(r, {0, 0, 0}, 0.5)) {
            ASSERT_NEAR(pixel.x, 0.5f, 0.005f) << "roughness " << roughness;
        }
    }
}

TEST_F(Probes, VanishInAWhiteFurnaceAtAnyRoughness) {
    for (int step = 0; step <= 10; ++step) {
        const float roughness = 0.1f * float(step);
        Scene scene;
        place(scene, sphere(0.5f, 64, addMaterial(scene, silver(1.0f, roughness))));
        FrameRequest r = lookingAt(std::move(scene), "furnace", {0.1, 0.3, 2.0}, {0, 0, 0});
        r.environment.map = "white";
        const std::vector<glm::vec3> pixels = ballPixels(r, {0, 0, 0}, 0.5);
        EXPECT_GT(pixels.size(), 3000u);
        for (const glm::vec3& pixel : pixels) {
            ASSERT_NEAR(pixel.x, 1.0f, 0.01f) << "roughness " << roughness;
        }
    }
}

TEST_F(Probes, BlurMoreTheRougherTheyAre) {
    double before = 1e9;
    for (int step = 0; step <= 10; ++step) {
        const float roughness = 0.1f * float(step);
        Scene scene;
        Room{glm::vec3(0.0f)}.build(scene);
        place(scene, quad(0.4f, addMaterial(scene, glowing(glm::vec3(1.0f)))),
              moved(0.5, 0.4, 2.9));
        place(scene, sphere(0.5f, 64, addMaterial(scene, silver(1.0f, roughness))));
        FrameRequest r = lookingAt(std::move(scene), "rough", {0, 0, 2.5}, {0, 0, 0});
        double brightest = 0.0;
        for (const glm::vec3& pixel : ballPixels(r, {0, 0, 0}, 0.5)) {
            brightest = std::max(brightest, double(pixel.x));
        }
        if (step == 0) {
            EXPECT_NEAR(brightest, 1.0, 0.01) << "a sharp image of the lamp";
        } else {
            EXPECT_LT(brightest, before * 1.001) << roughness;
        }
        if (step == 10) {
            EXPECT_LT(brightest, 0.2);
        }
        before = brightest;
    }
}

TEST_F(Probes, ShowObjectsThatTouchTheirOwner) {
    Scene scene;
    Room{glm::vec3(0.1f)}.build(scene);
    place(scene, sphere(0.5f, 64, addMaterial(scene, silver())));
    const glm::dmat4 facing = glm::rotate(moved(0.501, 0, 0), glm::half_pi<double>(), {0, 1, 0});
    place(scene, quad(0.15f, addMaterial(scene, glowing({1, 0, 0}))), facing);
    FrameRequest r = lookingAt(std::move(scene), "touching", {0.3, 0.2, 2.9}, {0, 0, 0});
    int red = 0;
    for (const glm::vec3& pixel : ballPixels(r, {0, 0, 0}, 0.45)) {
        red += pixel.x > 0.9f && pixel.y < 0.05f;
    }
    EXPECT_GT(red, 20);
}

// ---- generations -------------------------------------------------------------------------------

// Two balls of reflectance rho between walls of radiance 1, in the dark beyond.
Scene facingBalls(float rho, bool otherOrder, std::uint32_t rows = 64) {
    Scene scene;
    Room{glm::vec3(1.0f)}.build(scene);
    const Index metal = addMaterial(scene, silver(rho));
    const glm::dmat4 left = moved(-0.8, 0, 0), right = moved(0.8, 0.1, 0.05);
    place(scene, sphere(0.6f, rows, metal), otherOrder ? right : left);
    place(scene, sphere(0.6f, rows, metal), otherOrder ? left : right);
    return scene;
}

TEST_F(Probes, FacingEachOtherShowOneImagePerGeneration) {
    const float rho = 0.5f;
    for (std::uint32_t generations = 1; generations <= 3; ++generations) {
        FrameRequest r =
            lookingAt(facingBalls(rho, false), "facing balls", {0, 0.3, 2.8}, {0, 0, 0}, 256);
        r.accuracy.generations = generations;
        const Image image = renderer().render(r).image;
        std::array<int, 6> pixels{};  // of radiance rho^k; [0]: darker than any image
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const float value = color(image, x, y).x;
                if (value < 0.002f) ++pixels[0];
                for (std::size_t k = 1; k < pixels.size(); ++k) {
                    pixels[k] += std::abs(value / std::pow(rho, float(k)) - 1.0f) < 0.02f;
                }
            }
        }
        for (std::uint32_t k = 1; k < pixels.size(); ++k) {
            if (k <= generations) {
                EXPECT_GT(pixels[k], 4) << "image " << k << " of " << generations;
            } else {
                EXPECT_LE(pixels[k], 2) << "image " << k << " of " << generations;
            }
        }
        EXPECT_GT(pixels[0], 2) << "the image behind the last is the dark beyond the walls";
    }
}

TEST_F(Probes, AreIndependentOfFileOrder) {
    const auto picture = [](bool otherOrder) {
        FrameRequest r =
            lookingAt(facingBalls(0.8f, otherOrder, 24), "order", {0.4, 0.3, 2.8}, {0, 0, 0});
        r.environment.map = "sky";
        return renderer().render(r).image.data;
    };
    EXPECT_EQ(picture(false), picture(true));
}

// ---- what they cost ----------------------------------------------------------------------------

TEST_F(Probes, SwitchedOffEqualAPlainMetal) {
    const auto scene = [](Reflection reflection) {
        Scene s;
        Room{}.build(s);
        Material metal = silver(0.9f, 0.2f);
        metal.reflection = reflection;
        place(s, sphere(0.5f, 32, addMaterial(s, metal)));
        return s;
    };
    FrameRequest off = lookingAt(scene(Reflection::automatic), "off", {1, 1, 2}, {0, 0, 0});
    off.effects.environmentReflection = false;
    off.environment.map = "sky";
    FrameRequest without = lookingAt(scene(Reflection::none), "without", {1, 1, 2}, {0, 0, 0});
    without.environment.map = "sky";
    const Frame frame = renderer().render(off);
    EXPECT_EQ(frame.image.data, renderer().render(without).image.data);
    for (const Pass& pass : frame.plan.passes) EXPECT_NE(pass.kind(), "capture");
}

TEST_F(Probes, AreDrawnOnceAsPlanned) {
    FrameRequest r = lookingAt(facingBalls(0.8f, false, 24), "kept", {0.4, 0.3, 2.8}, {0, 0, 0});
    const auto faces = [](const FramePlan& plan) {
        return std::count_if(plan.passes.begin(), plan.passes.end(),
                             [](const Pass& p) { return p.kind() == "capture"; });
    };
    Image last;
    for (int frame = 0; frame < 4; ++frame) {
        if (frame == 1) r.camera.position = glm::dvec3(-0.5, 1.0, 2.5);
        if (frame == 3) r.accuracy.probeSamples = 8;
        const RendererCounters before = renderer().counters();
        const Frame drawn = renderer().render(r);
        const RendererCounters after = renderer().counters();
        const PlanTotals totalsOfPlan = totals(drawn.plan);
        EXPECT_EQ(after.drawCalls - before.drawCalls, totalsOfPlan.draws) << frame;
        EXPECT_EQ(after.triangles - before.triangles, totalsOfPlan.triangles) << frame;
        EXPECT_EQ(faces(drawn.plan), frame == 0 || frame == 3 ? 24 : 0) << frame;
        if (frame == 2) {
            EXPECT_EQ(drawn.image.data, last.data) << "the same request, the same bytes";
            EXPECT_EQ(after.texturesMade, before.texturesMade)
                << "a steady frame creates no objects";
            EXPECT_EQ(after.framebuffersMade, before.framebuffersMade);
        }
        last = drawn.image;
    }
}

// A capture that a frame made and one that it found give one picture.
TEST_F(Probes, ResidentCubesEqualNewOnes) {
    FrameRequest r = lookingAt(facingBalls(0.8f, false, 24), "fresh", {0.4, 0.3, 2.8}, {0, 0, 0});
    r.environment.map = "sky";
    const Image fresh = renderer().render(r).image;
    EXPECT_EQ(renderer().render(r).image.data, fresh.data);
}

}  // namespace
}  // namespace clerestory::test
