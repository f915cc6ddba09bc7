// Flat mirrors compared with an explicitly mirrored scene and with arithmetic, and their cost.
#include "support.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace clerestory::test {
namespace {

class Mirrors : public GlTest {};

constexpr double kHalf = 1.5;  // of the mirror, metres

// Small glowing squares, each of its own colour, in front of the plane z = 0 and around the eye.
void placeLamps(Scene& scene, const glm::dmat4& worldFromLamps) {
    const glm::dvec3 places[] = {
        {-0.8, 0.3, 0.7}, {0.5, -0.6, 1.2}, {0.9, 0.8, 2.5}, {-0.3, -0.9, 3.0}, {0.1, 0.9, 0.4}};
    int i = 0;
    for (const glm::dvec3& at : places) {
        const glm::vec3 radiance(0.2f + 0.15f * float(i), 1.0f - 0.1f * float(i), 0.1f * float(i));
        glm::dmat4 m = glm::translate(glm::dmat4(1.0), at);
        m = glm::rotate(m, 0.4 * i, glm::dvec3(0.3, 1.0, 0.2));
        place(scene, quad(0.25f, addMaterial(scene, glowing(radiance))), worldFromLamps * m);
        ++i;
    }
}

void forceMirrors(FrameRequest& r) {
    r.accuracy.planar = PlanarMethod::mirror;
    // Small emitters at the border of a mirror's picture have no neighbours there.
    r.accuracy.emitterCoverage = false;
}

// Two ways to one picture: the mirror, and a hole through which a mirrored copy of the world is
// seen, for a camera that looks askew, with and without a shifted lens.
TEST_F(Mirrors, ShowTheMirroredSceneThroughAHole) {
    for (const bool shifted : {false, true}) {
        for (const double roll : {0.0, 0.7, 3.1}) {
            Scene world, copy;
            placeLamps(world, glm::dmat4(1.0));
            place(world, quad(float(kHalf), addMaterial(world, mirrorMetal())));
            placeLamps(copy, glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, -1.0)));

            FrameRequest r = request(std::move(world), "mirrored", {0.4, 0.3, 2.0});
            r.width = 96;
            r.camera.target = glm::dvec3(-0.1, 0.1, 0.0);
            r.camera.up = glm::dvec3(std::sin(roll), std::cos(roll), 0.1);
            if (shifted) {
                r.camera.yfov.reset();
                r.camera.intrinsics = Intrinsics{.fx = 40, .fy = 40, .cx = 61.25, .cy = 20.5};
            }
            forceMirrors(r);
            const Image seen = renderer().render(r).image;
            FrameRequest ids = r;
            ids.output.channel = Channel::objectId;
            const Image objects = renderer().render(ids).image;
            FrameRequest direct = request(std::move(copy), "copy");
            direct.camera = r.camera;
            direct.accuracy = r.accuracy;
            direct.width = r.width;
            const Image expected = renderer().render(direct).image;

            int compared = 0, off = 0, lit = 0;
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 0; x < r.width; ++x) {
                    if (number(objects, x, y) != 6.0f) continue;
                    ++compared;
                    lit += color(expected, x, y).y > 0.0f;
                    off += glm::distance(color(seen, x, y), color(expected, x, y)) > 2e-3f;
                }
            }
            ASSERT_GT(compared, 1000);
            EXPECT_GT(lit, 50);
            EXPECT_EQ(off, 0) << "of " << compared << " pixels, roll " << roll;
        }
    }
}

TEST_F(Mirrors, ShowRadianceTimesReflectance) {
    for (const float radiance : {0.01f, 1.0f, 10.0f, 1e4f}) {
        Scene scene;
        place(scene, quad(8.0f, addMaterial(scene, glowing(glm::vec3(radiance)))), moved(0, 0, 4));
        place(scene, quad(1.0f, addMaterial(scene, mirrorMetal(0.5f))));
        FrameRequest r = request(std::move(scene), "lamp in a mirror", {0, 0, 1});
        forceMirrors(r);
        EXPECT_NEAR(centerColor(renderer().render(r).image).x / (0.5f * radiance), 1.0f, 0.01f)
            << radiance;
    }
}

TEST_F(Mirrors, VanishInAConstantEnvironment) {
    for (const float roughness : {0.0f, 0.2f, 0.5f}) {
        Scene scene;
        place(scene, quad(0.5f, addMaterial(scene, mirrorMetal(1.0f, roughness))));
        FrameRequest r = request(std::move(scene), "furnace", {0.2, 0.1, 1});
        r.environment.map = "white";
        forceMirrors(r);
        const Image image = renderer().render(r).image;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                ASSERT_NEAR(color(image, x, y).x, 1.0f, 0.005f) << x << ' ' << y;
            }
        }
    }
}

TEST_F(Mirrors, ShowNothingFromBehindTheirPlane) {
    Scene scene;
    place(scene, quad(0.8f, addMaterial(scene, mirrorMetal())));
    place(scene, quad(8.0f, addMaterial(scene, glowing({1, 0, 0}))), moved(0, 0, -0.5));
    FrameRequest r = request(std::move(scene), "behind", {0, 0, 1});
    forceMirrors(r);
    EXPECT_EQ(centerColor(renderer().render(r).image), glm::vec3(0.0f));
}

// Two mirrors face each other, the eye between them, a lamp with a hole's width of sight: the k-th
// image is rho^k of the lamp.
TEST_F(Mirrors, FacingEachOtherAttenuateByTheReflectance) {
    const float rho = 0.5f;
    for (std::uint32_t generations = 1; generations <= 5; ++generations) {
        Scene scene;
        const Index silver = addMaterial(scene, mirrorMetal(rho));
        place(scene, quad(4.0f, silver), moved(0, 0, -1));
        place(scene, quad(4.0f, silver),
              glm::rotate(moved(0, 0, 1), glm::pi<double>(), glm::dvec3(0, 1, 0)));
        // Between them and off the line of sight; its images stand at odd multiples of the gap.
        place(scene, quad(0.03f, addMaterial(scene, glowing(glm::vec3(1.0f)))), moved(0.5, 0, 0));
        FrameRequest r = request(std::move(scene), "facing", {0, 0, 0});
        r.width = r.height = 800;
        forceMirrors(r);
        r.accuracy.generations = generations;
        const Image image = renderer().render(r).image;
        for (std::uint32_t k = 1; k <= 5; ++k) {
            // Seen at z = -2k: the lamp is in the eye's plane, the planes one metre away.
            const double x = 400.0 + 400.0 * 0.5 / (2.0 * k);
            const float value = color(image, std::uint32_t(x), 400).x;
            const float expected = k <= generations ? std::pow(rho, float(k)) : 0.0f;
            EXPECT_NEAR(value, expected, 0.02f * expected + 1e-6f)
                << "image " << k << " of " << generations << " generations";
        }
    }
}

// A wall of two triangles stands before the mirror: no mirrored view, and the same picture as if it
// had been drawn. Next to the wall there is a hole, and it is drawn.
TEST_F(Mirrors, HiddenBehindAWallCostNothing) {
    for (const double aside : {0.0, 0.6}) {
        Scene scene;
        place(scene, quad(0.3f, addMaterial(scene, mirrorMetal())));
        place(scene, quad(0.5f, addMaterial(scene, glowing({0, 0, 1}))), moved(aside, 0, 1));
        FrameRequest r = request(std::move(scene), "hidden", {0, 0, 2});
        r.accuracy.planar = PlanarMethod::mirror;  // whatever a view costs
        const FramePlan plan = renderer().plan(r);
        const bool drawn = std::any_of(plan.passes.begin(), plan.passes.end(),
                                       [](const Pass& pass) { return pass.kind() == "mirror"; });
        EXPECT_EQ(drawn, aside > 0.0);
        const bool reported =
            std::any_of(plan.skipped.begin(), plan.skipped.end(), [](const Skipped& skipped) {
                return skipped.reason.find("hidden behind") != std::string::npos;
            });
        EXPECT_EQ(reported, aside == 0.0);
    }
}

TEST_F(Mirrors, SwitchedOffEqualAPlainMetal) {
    const auto scene = [](Material material) {
        Scene s;
        placeLamps(s, glm::dmat4(1.0));
        place(s, quad(float(kHalf), addMaterial(s, std::move(material))));
        return s;
    };
    FrameRequest off = request(scene(mirrorMetal()), "off", {0.4, 0.3, 2.0});
    off.effects.planarReflection = false;
    off.environment.map = "sky";
    Material refused = mirrorMetal();
    refused.reflection = Reflection::none;
    FrameRequest without = request(scene(refused), "without", {0.4, 0.3, 2.0});
    without.environment.map = "sky";
    EXPECT_EQ(renderer().render(off).image.data, renderer().render(without).image.data);
}

// The mirror covers another number of pixels in each frame.
TEST_F(Mirrors, PicturesOfACameraThatMovesAreMadeOnce) {
    Scene scene;
    placeLamps(scene, glm::dmat4(1.0));
    place(scene, quad(float(kHalf), addMaterial(scene, mirrorMetal())));
    FrameRequest r = request(std::move(scene), "moving", {0.4, 0.3, 4.0});
    r.width = 512;
    r.height = 384;
    forceMirrors(r);
    std::set<std::pair<std::uint32_t, std::uint32_t>> sizes;
    const auto draw = [&](int frame) {
        r.camera.position = glm::dvec3(0.4, 0.3, 4.0 + 0.012 * frame);
        const Frame drawn = renderer().render(r);
        for (const TargetSpec& target : drawn.plan.targets) {
            if (target.name.starts_with("mirror:")) sizes.insert({target.width, target.height});
        }
    };
    draw(0);
    const std::uint64_t before = renderer().counters().texturesMade;
    for (int frame = 1; frame < 48; ++frame) draw(frame);
    // It shrinks by about 40 pixels each way, and its picture by steps of 16 at each border.
    EXPECT_GT(sizes.size(), 2u);
    EXPECT_LE(sizes.size(), 13u);
    EXPECT_EQ(renderer().counters().texturesMade - before, 2 * (sizes.size() - 1))
        << "colour and depth";
}

TEST_F(Mirrors, BlurMoreTheRougherTheyAre) {
    double before = 0.0;
    for (const float roughness : {0.0f, 0.1f, 0.2f, 0.3f, 0.4f}) {
        Scene scene;
        place(scene, quad(3.0f, addMaterial(scene, mirrorMetal(1.0f, roughness))));
        place(scene, quad(0.2f, addMaterial(scene, glowing(glm::vec3(1.0f)))), moved(0, 0, 2));
        FrameRequest r = request(std::move(scene), "rough", {0, 0, 1});
        r.camera.target = glm::dvec3(0.0, 0.0, 0.0);
        r.camera.position = glm::dvec3(0.0, 0.4, 1.0);
        r.width = r.height = 128;
        forceMirrors(r);
        const Image image = renderer().render(r).image;
        double sum = 0.0, squares = 0.0;  // of the light, and of its distance from its middle
        glm::dvec2 mean(0.0);
        for (int pass = 0; pass < 2; ++pass) {
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 0; x < r.width; ++x) {
                    const double light = color(image, x, y).x;
                    if (pass == 0) {
                        sum += light;
                        mean += light * glm::dvec2(x, y);
                    } else {
                        const glm::dvec2 d = glm::dvec2(x, y) - mean / sum;
                        squares += light * glm::dot(d, d) / sum;
                    }
                }
            }
        }
        EXPECT_GT(squares, before * 1.02) << roughness;
        before = squares;
    }
}

// A road whose left half is smooth and whose right half is rough: the left one is the mirror that a
// smooth road is, and the right one is as dull as a rough road.
TEST_F(Mirrors, SmoothPatchesMirrorAndTheRestDoesNot) {
    enum class Road { smooth, rough, both };
    for (const PlanarMethod method : {PlanarMethod::mirror, PlanarMethod::traced}) {
        const auto drawn = [&](Road road) {
            Scene scene;
            Material wet;
            wet.metallic = 0.0f;
            wet.baseColor = {0.1f, 0.1f, 0.1f, 1.0f};
            wet.ior = 3.0f;
            wet.roughness = road == Road::rough    ? 204.0f / 255.0f
                            : road == Road::smooth ? 0.0f
                                                   : 1.0f;
            if (road == Road::both) {
                const glm::u8vec4 low(0, 0, 0, 255), high(0, 204, 0, 255);
                wet.metallicRoughnessTexture.texture =
                    addTexture2x2(scene, {low, high, low, high}, Wrap::clampToEdge);
                scene.images.back().mean = {0.0f, 0.4f, 0.0f, 1.0f};
                scene.images.back().leastGreen = 0.0f;
            }
            place(scene, quad(2.0f, addMaterial(scene, std::move(wet))));
            for (const double x : {-2.2, 2.2}) {
                const Material lamp = glowing(glm::vec3(1.0f, 0.5f, 0.2f));
                place(scene, quad(0.3f, addMaterial(scene, lamp)), moved(x, 0.4, 1.5));
            }
            FrameRequest r = request(std::move(scene), "road", {0.0, 0.0, 1.4});
            r.width = r.height = 96;
            r.accuracy.planar = method;
            r.accuracy.emitterCoverage = false;
            return renderer().render(r).image;
        };
        const Image both = drawn(Road::both), smooth = drawn(Road::smooth),
                    rough = drawn(Road::rough);
        double most = 0.0;
        for (std::uint32_t y = 0; y < 96; ++y) {
            for (std::uint32_t x = 0; x < 96; ++x) {
                // The texture is interpolated between the middles of its texels.
                if (x >= 20 && x < 76) continue;
                const glm::vec3 expected = color(x < 48 ? smooth : rough, x, y);
                for (int k = 0; k < 3; ++k) {
                    EXPECT_NEAR(color(both, x, y)[k], expected[k], 0.002f) << x << ' ' << y;
                }
                most =
                    std::max(most, double(std::abs(color(smooth, x, y).x - color(rough, x, y).x)));
            }
        }
        EXPECT_GT(most, 0.1) << "the halves differ";
    }
}

// A pillar of long triangles, of which each corner comes first once: its normals turn across them
// and not along them.
MeshDraft pillar(float radius, float height, Index material) {
    constexpr std::uint32_t kSides = 24;
    MeshDraft draft{.name = "pillar", .material = material, .hasNormals = true};
    for (std::uint32_t i = 0; i <= kSides; ++i) {
        const float angle = 2.0f * glm::pi<float>() * float(i) / float(kSides);
        const glm::vec3 n(std::sin(angle), 0.0f, std::cos(angle));
        for (const float y : {-0.5f, 0.5f}) {
            draft.vertices.push_back(
                {.position = radius * n + glm::vec3(0.0f, height * y, 0.0f), .normal = n});
        }
    }
    for (std::uint32_t i = 0; i < kSides; ++i) {
        const std::array<std::uint32_t, 3> corners[] = {{2 * i, 2 * i + 2, 2 * i + 3},
                                                        {2 * i, 2 * i + 3, 2 * i + 1}};
        for (const auto& c : corners) {
            for (std::uint32_t k = 0; k < 3; ++k) draft.indices.push_back(c[(i + k) % 3]);
        }
    }
    return draft;
}

// The highlight of a pillar is narrower than a pixel. A ray averages it over its cone, whatever the
// shape of the triangle that it meets: the light of small pictures is that of a large one.
TEST_F(Mirrors, RaysShowTheMeanHighlightOfLongTriangles) {
    Scene scene;
    place(scene, quad(3.0f, addMaterial(scene, mirrorMetal())));
    place(scene, pillar(1.0f, 12.0f, addMaterial(scene, {.metallic = 1.0f, .roughness = 0.1f})),
          moved(0.0, 0.0, 5.0));
    addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(3.0f)},
             glm::rotate(glm::dmat4(1.0), 2.7, glm::dvec3(0, 1, 0)));
    FrameRequest r = request(std::move(scene), "pillar in a mirror");
    r.accuracy.planar = PlanarMethod::traced;
    const auto light = [&](std::uint32_t edge) {
        r.width = r.height = edge;
        const Image image = renderer().render(r).image;
        double sum = 0.0;
        for (std::uint32_t i = 0; i < edge * edge; ++i) sum += color(image, i % edge, i / edge).x;
        return sum / (double(edge) * edge);
    };
    const double truth = light(768);
    EXPECT_GT(truth, 0.0);
    for (const std::uint32_t edge : {20u, 26u, 32u, 37u, 50u}) {
        EXPECT_GT(light(edge), 0.7 * truth) << edge;
        EXPECT_LT(light(edge), 1.7 * truth) << edge;
    }
}

}  // namespace
}  // namespace clerestory::test
