// Lighting with known results: furnaces, single lights.
#include "support.h"

#include "scene/environment.h"

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace formulae {
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
}  // namespace formulae
#pragma GCC diagnostic pop

class LightOnSurfaces : public GlTest {};

constexpr float kPi = 3.14159265358979f;

float centerAfterLight(const Light& light, const glm::dmat4& worldFromLight, const char* id) {
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))));
    addLight(scene, light, worldFromLight);
    FrameRequest r = request(std::move(scene), id, {0, 0, 1});
    r.width = r.height = 65;  // a pixel's centre looks straight ahead
    const glm::vec3 seen = centerColor(renderer().render(r).image);
    EXPECT_EQ(seen.x, seen.y);
    EXPECT_EQ(seen.x, seen.z);
    return seen.x;
}

}  // namespace

TEST_F(LightOnSurfaces, WhiteMetalVanishesInAWhiteFurnace) {
    for (const float roughness : {0.0f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
        // glTF mixes two materials of which each sends all light back.
        for (const float metallic : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f}) {
            Scene scene;
            const Index white = addMaterial(scene, {.metallic = metallic, .roughness = roughness});
            place(scene, sphere(1.0f, 48, white));
            FrameRequest r = request(std::move(scene), "furnace");
            r.environment.map = "white";
            const Image image = renderer().render(r).image;
            for (std::uint32_t y = 0; y < image.height; ++y) {
                for (std::uint32_t x = 0; x < image.width; ++x) {
                    ASSERT_NEAR(color(image, x, y).x, 1.0f, 0.01f)
                        << "roughness " << roughness << " metallic " << metallic << " at " << x
                        << " " << y;
                }
            }
        }
    }
}

// A normal of 60 degrees seen from 40 degrees above the face on the other side turns away from the
// eye. What leaves the face is at most 140 degrees from the eye, so that a facet is met at 70
// degrees at most, where glass of index 1.5 reflects 17 % (Fresnel).
TEST_F(LightOnSurfaces, NormalsThatTurnAwayMirrorNoMoreThanTheFaceLets) {
    for (const float roughness : {0.0f, 0.1f, 0.3f}) {
        Scene scene;
        Material black = lambert(0.0f);
        black.specular = 1.0f;
        black.roughness = roughness;
        MeshDraft draft = quad(2.0f, addMaterial(scene, black));
        for (Vertex& vertex : draft.vertices) vertex.normal = {0.8660254f, 0.0f, 0.5f};
        place(scene, std::move(draft));
        FrameRequest r = request(std::move(scene), "turned");
        r.environment.map = "white";
        r.camera.position = {-0.7660444, 0.0, 0.6427876};
        r.camera.target = {0.0, 0.0, 0.0};
        r.width = r.height = 65;
        const float reflected = centerColor(renderer().render(r).image).x;
        EXPECT_LE(reflected, 0.18f) << roughness;
        EXPECT_GE(reflected, 0.08f) << roughness;
    }
}

TEST_F(LightOnSurfaces, APointLightFallsOffWithTheSquareOfDistance) {
    for (const double distance : {0.5, 1.0, 2.0, 4.0}) {
        const float seen =
            centerAfterLight({.intensity = glm::vec3(3.0f)}, moved(0.0, 0.0, distance), "point");
        const auto d = static_cast<float>(distance);
        EXPECT_NEAR(seen, 0.5f / kPi * 3.0f / (d * d), 1e-3f * seen) << distance;
    }
}

TEST_F(LightOnSurfaces, APointLightStopsAtItsRange) {
    const Light light{.intensity = glm::vec3(3.0f), .range = 2.0f};
    const float near = centerAfterLight(light, moved(0, 0, 1), "range");
    EXPECT_NEAR(near, 0.5f / kPi * 3.0f * (1.0f - 1.0f / 16.0f), 1e-3f * near);
    EXPECT_EQ(centerAfterLight(light, moved(0, 0, 2), "range"), 0.0f);
}

TEST_F(LightOnSurfaces, DirectionalLightFollowsTheCosine) {
    for (const double angle : {0.0, 0.5, 1.0, 1.5}) {
        glm::dmat4 turned(1.0);  // about Y; the light shines along its -Z
        turned[0] = {std::cos(angle), 0, -std::sin(angle), 0};
        turned[2] = {std::sin(angle), 0, std::cos(angle), 0};
        const float seen = centerAfterLight(
            {.kind = LightKind::directional, .intensity = glm::vec3(2.0f)}, turned, "sun");
        EXPECT_NEAR(seen, 0.5f / kPi * 2.0f * static_cast<float>(std::cos(angle)), 1e-3f) << angle;
    }
}

TEST_F(LightOnSurfaces, ALightBehindASurfaceDoesNotReachIt) {
    EXPECT_EQ(centerAfterLight({.intensity = glm::vec3(3.0f)}, moved(0, 0, -1), "behind"), 0.0f);
}

TEST_F(LightOnSurfaces, ASpotLightsItsConeOnly) {
    const Light spot{.kind = LightKind::spot,
                     .intensity = glm::vec3(1.0f),
                     .innerConeAngle = 0.2f,
                     .outerConeAngle = 0.4f};
    const float centre = centerAfterLight(spot, moved(0, 0, 1), "spot");
    EXPECT_NEAR(centre, 0.5f / kPi, 1e-3f);
    // tan(0.4) = 0.42: one metre aside the cone is past.
    EXPECT_EQ(centerAfterLight(spot, moved(1.0, 0, 1), "spot"), 0.0f);
}

TEST_F(LightOnSurfaces, AMatteSurfaceInGreyLightHasItsAlbedoTimesThatLight) {
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))));
    FrameRequest r = request(std::move(scene), "grey");
    r.environment.map = "grey";
    r.environment.intensity = 3.0;
    EXPECT_NEAR(centerColor(renderer().render(r).image).x, 0.5f * 0.18f * 3.0f, 1e-3f);
}

TEST_F(LightOnSurfaces, OcclusionAffectsOnlyTheEnvironment) {
    const auto seen = [](bool occluded, const char* environment, float lamp) {
        Scene scene;
        Material m = lambert(0.5f);
        m.occlusionTexture.texture = addTexture2x2(
            scene, {glm::u8vec4(51), glm::u8vec4(51), glm::u8vec4(51), glm::u8vec4(51)},
            Wrap::repeat);
        m.occlusionStrength = occluded ? 1.0f : 0.0f;
        place(scene, quad(2.0f, addMaterial(scene, m)));
        if (lamp > 0.0f) addLight(scene, {.intensity = glm::vec3(lamp)}, moved(0, 0, 1));
        FrameRequest r = request(std::move(scene), "occlusion");
        r.environment.map = environment;
        return centerColor(renderer().render(r).image).x;
    };
    EXPECT_NEAR(seen(true, "white", 0), 0.2f * seen(false, "white", 0), 1e-3f);
    EXPECT_EQ(seen(true, "black", 1), seen(false, "black", 1));
}

// A pixel shows the mean of its highlight: coarse pictures have the light of fine ones, wherever
// the points of their pixels happen to lie. Seen at one point each, they have a third of it or
// thrice.
TEST_F(LightOnSurfaces, HighlightEnergyIsIndependentOfResolution) {
    for (const float roughness : {0.05f, 0.2f}) {
        Scene scene;
        const Index gold = addMaterial(scene, {.roughness = roughness});
        place(scene, sphere(0.5f, 96, gold));
        addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(2.0f)},
                 glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(0.6, 0.8, 0.0)));
        FrameRequest r = request(std::move(scene), "ball", {0, 0, 3});
        r.environment.map = "black";
        const auto lightAt = [&](std::uint32_t edge) {
            r.width = r.height = edge;
            const Image image = renderer().render(r).image;
            double sum = 0.0;
            for (std::size_t i = 0; i < std::size_t{3} * edge * edge; ++i) sum += image.floats()[i];
            return sum / (double(edge) * edge);
        };
        const double fine = lightAt(1024);
        for (const std::uint32_t edge : {24u, 33u, 47u, 64u}) {
            EXPECT_NEAR(lightAt(edge) / fine, 1.0, 0.2) << roughness << ' ' << edge;
        }
    }
}

// As above, with triangles smaller than pixels, of which each covers some of four samples.
TEST_F(LightOnSurfaces, HighlightsOfSmallTrianglesAreSeenWithSeveralSamples) {
    Scene scene;
    const Index gold = addMaterial(scene, {.roughness = 0.1f});
    for (int i = 0; i < 16; ++i) {
        place(scene, sphere(0.5f, 48, gold), moved(1.5 * (i % 4) - 2.25, 1.5 * (i / 4) - 2.25, 0));
    }
    addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(2.0f)},
             glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(0.6, 0.8, 0.0)));
    FrameRequest r = request(std::move(scene), "balls", {0, 0, 3});
    r.environment.map = "black";
    const auto lightsAt = [&](std::uint32_t edge, std::uint32_t samples) {
        r.width = r.height = edge;
        r.accuracy.samples = samples;
        const Image image = renderer().render(r).image;
        std::array<double, 16> sums{};  // of each ball
        for (std::uint32_t y = 0; y < edge; ++y) {
            for (std::uint32_t x = 0; x < edge; ++x) {
                sums[4 * (4 * y / edge) + 4 * x / edge] += color(image, x, y).x;
            }
        }
        for (double& sum : sums) sum /= double(edge) * edge;
        return sums;
    };
    const std::array<double, 16> truth = lightsAt(1024, 1);
    double squares = 0.0;
    for (const std::uint32_t edge : {32u, 44u, 60u}) {
        const std::array<double, 16> sums = lightsAt(edge, 4);
        for (std::size_t i = 0; i < 16; ++i) squares += std::pow(sums[i] / truth[i] - 1.0, 2.0);
    }
    EXPECT_LT(std::sqrt(squares / 48.0), 0.45);
}

// Nothing is reflected where the index does not change, at no angle (Fresnel); just above, little.
TEST_F(LightOnSurfaces, WithoutAChangeOfIndexThereIsNoHighlight) {
    const auto seen = [](float ior, float specular) {
        Scene scene;
        Material m{.baseColor = {0.2f, 0.1f, 0.05f, 1}, .metallic = 0.0f, .roughness = 0.3f};
        m.ior = ior;
        m.specular = specular;
        place(scene, sphere(0.5f, 48, addMaterial(scene, m)));
        addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(2.0f)},
                 glm::rotate(glm::dmat4(1.0), 2.6, glm::dvec3(0.0, 1.0, 0.0)));  // from behind
        FrameRequest r = request(std::move(scene), "index", {0, 0, 2});
        r.environment.map = "sky";
        return renderer().render(r).image;
    };
    const auto brightest = [](const Image& image) {
        const std::size_t count = std::size_t{image.width} * image.height * image.channels;
        return *std::max_element(image.floats(), image.floats() + count);
    };
    EXPECT_EQ(seen(1.0f, 1.0f).data, seen(1.0f, 0.0f).data);
    EXPECT_LT(brightest(seen(1.001f, 1.0f)), 1.2f * brightest(seen(1.0f, 1.0f)));
    EXPECT_GT(brightest(seen(1.5f, 1.0f)), 2.0f * brightest(seen(1.0f, 1.0f)));
}

TEST_F(LightOnSurfaces, HighlightsMatchTheirFormula) {
    for (const float roughness : {0.05f, 0.2f, 0.5f, 1.0f}) {
        for (const double angle : {0.02, 0.4, 1.2}) {
            Scene scene;
            const glm::vec3 gold(1.0f, 0.7f, 0.3f);
            place(scene, quad(2.0f, addMaterial(scene, {.baseColor = glm::vec4(gold, 1),
                                                        .roughness = roughness})));
            const glm::dvec3 lamp = 2.0 * glm::dvec3(std::sin(angle), 0.0, std::cos(angle));
            addLight(scene, {.intensity = glm::vec3(3.0f)}, moved(lamp.x, lamp.y, lamp.z));
            FrameRequest r = request(std::move(scene), "highlight", {0, 0, 1});
            r.width = r.height = 65;
            r.camera.yfov = 0.018;  // a pixel is a point: it averages over what it covers
            const glm::vec3 seen = centerColor(renderer().render(r).image);

            const glm::vec3 n(0, 0, 1), v(0, 0, 1), l(lamp / 2.0), h = glm::normalize(l + v);
            const glm::vec3 across = glm::cross(n, h);
            const float alpha = roughness * roughness;
            const glm::vec2 ab = environmentBrdf(1.0f, roughness);
            const glm::vec3 bounces = 1.0f + gold * (1.0f / (ab.x + ab.y) - 1.0f);
            const glm::vec3 expected =
                formulae::fresnelSchlick(gold, glm::vec3(1.0f), glm::dot(v, h)) * bounces *
                formulae::ggxDistribution(glm::dot(n, h), glm::dot(across, across), alpha) *
                formulae::ggxVisibility(glm::dot(n, l), glm::dot(n, v), alpha) * glm::dot(n, l) *
                3.0f * formulae::punctualAttenuation(2.0f, 0.0f);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(seen[c], expected[c], 5e-3f * expected[c] + 1e-6f)
                    << "roughness " << roughness << " angle " << angle;
            }
        }
    }
}

// glTF: the metal and the dielectric are mixed by `metallic`, not their reflectances.
TEST_F(LightOnSurfaces, PartlyMetallicSurfacesAreTheMixtureOfBothMaterials) {
    const auto seen = [](float metallic, float roughness, double angle) {
        Scene scene;
        place(scene, quad(2.0f, addMaterial(scene, {.baseColor = {0.9f, 0.9f, 0.4f, 1.0f},
                                                    .metallic = metallic,
                                                    .roughness = roughness})));
        const glm::dvec3 source = 2.0 * glm::dvec3(std::sin(angle), 0.0, std::cos(angle));
        addLight(scene, {.intensity = glm::vec3(3.0f)}, moved(source.x, source.y, source.z));
        FrameRequest r = request(std::move(scene), "mixture", {0.5, 0, 1});
        r.width = r.height = 65;
        r.camera.target = glm::dvec3(0.0);
        r.camera.yfov = 0.018;
        return centerColor(renderer().render(r).image);
    };
    for (const float roughness : {0.3f, 0.6f, 0.8f, 1.0f}) {
        for (const double angle : {0.1, 0.7, 1.2}) {
            const glm::vec3 dielectric = seen(0.0f, roughness, angle),
                            metal = seen(1.0f, roughness, angle);
            for (const float metallic : {0.3f, 0.5f, 0.9f}) {
                const glm::vec3 expected = glm::mix(dielectric, metal, metallic),
                                mixed = seen(metallic, roughness, angle);
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(mixed[c], expected[c], 5e-3f * expected[c])
                        << roughness << " " << angle << " " << metallic;
                }
            }
        }
    }
}

namespace {

// A smooth black or white dielectric under a white sky and a light that is far above the eye: the
// centre is seen at 3.6 degrees from grazing.
glm::vec3 seenAtGrazing(float specular, float base, float roughness, const char* environment) {
    Scene scene;
    place(scene, quad(4.0f, addMaterial(scene, {.baseColor = glm::vec4(glm::vec3(base), 1),
                                                .metallic = 0.0f,
                                                .roughness = roughness,
                                                .specular = specular})));
    addLight(scene, {.intensity = glm::vec3(500.0f)}, moved(-3, 0, 0.2));
    FrameRequest r = request(std::move(scene), "specular", {1.6, 0, 0.1});
    r.camera.target = glm::dvec3(0);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.environment.map = environment;
    r.effects.planarReflection = false;
    return centerColor(renderer().render(r).image);
}

}  // namespace

TEST_F(LightOnSurfaces, ASpecularFactorWeighsTheDielectricLobeAtEveryAngle) {
    for (const float roughness : {0.05f, 0.3f, 0.8f}) {
        // Black, and nothing on it.
        EXPECT_EQ(seenAtGrazing(0.0f, 0.0f, roughness, "white"), glm::vec3(0.0f)) << roughness;
        // Linear in the weight, but for the bounces between its facets.
        for (const char* environment : {"white", "black"}) {
            const glm::vec3 whole = seenAtGrazing(1.0f, 0.0f, roughness, environment);
            const glm::vec3 half = seenAtGrazing(0.5f, 0.0f, roughness, environment);
            ASSERT_GT(whole.x, 0.1f) << environment << roughness;
            EXPECT_NEAR(half.x / whole.x, 0.5f, 5e-3f) << environment << roughness;
        }
        // The remainder of the lobe is diffuse: white stays white, without the light's
        // contribution.
        for (const float specular : {0.0f, 0.3f, 1.0f}) {
            const float seen = seenAtGrazing(specular, 1.0f, roughness, "white").x -
                               seenAtGrazing(specular, 1.0f, roughness, "black").x;
            EXPECT_NEAR(seen, 1.0f, 5e-3f) << specular << " " << roughness;
        }
    }
}

TEST_F(LightOnSurfaces, PartlyTransmittingSurfacesConserveUniformLight) {
    for (const float transmission : {0.0f, 0.25f, 0.5f, 1.0f}) {
        Scene scene;
        place(scene, quad(4.0f, addMaterial(scene, {.metallic = 0.0f,
                                                    .roughness = 0.4f,
                                                    .transmission = transmission})));
        FrameRequest r = request(std::move(scene), "halfClear", {0, 0, 1});
        r.environment.map = "white";
        EXPECT_NEAR(centerColor(renderer().render(r).image).x, 1.0f, 5e-3f) << transmission;
    }
}

TEST_F(LightOnSurfaces, LampsWithoutLimitsShineAsThoseOfAHugeRange) {
    for (int lamps = 1; lamps <= 4; ++lamps) {
        Image images[2];
        for (const float range : {0.0f, 1e9f}) {
            Scene scene;
            place(scene,
                  sphere(1.0f, 24, addMaterial(scene, {.metallic = 0.5f, .roughness = 0.4f})));
            for (int i = 0; i < lamps; ++i) {
                addLight(scene,
                         {.kind = LightKind::point,
                          .intensity = glm::vec3(5.0f + float(i)),
                          .range = range},
                         moved(2.0 * i - 3.0, 2.0, 2.0));
            }
            FrameRequest r = request(std::move(scene), "lamps");
            r.environment.map = "sky";
            images[range > 0.0f] = renderer().render(r).image;
        }
        for (std::uint32_t y = 0; y < images[0].height; ++y) {
            for (std::uint32_t x = 0; x < images[0].width; ++x) {
                const glm::vec3 a = color(images[0], x, y), b = color(images[1], x, y);
                ASSERT_LE(glm::length(a - b), 2e-3f * glm::length(a))
                    << lamps << ": " << x << ' ' << y;
            }
        }
    }
}

// The tolerance alone decides whether a rough ball mirrors the prefiltered map or its harmonics.
TEST_F(LightOnSurfaces, HarmonicsShowWhatThePrefilteredMapDoes) {
    for (const float roughness : {0.8f, 0.9f, 1.0f}) {
        Scene scene;
        place(scene,
              sphere(1.0f, 48, addMaterial(scene, {.metallic = 0.0f, .roughness = roughness})));
        FrameRequest r = request(std::move(scene), "wide lobe");
        r.environment.map = "sky";
        r.accuracy.preset = Preset::fine;
        const Image prefiltered = renderer().render(r).image;
        r.accuracy.preset = Preset::standard;
        const Frame harmonics = renderer().render(r);
        double squares = 0.0;
        for (std::uint32_t y = 0; y < prefiltered.height; ++y) {
            for (std::uint32_t x = 0; x < prefiltered.width; ++x) {
                const glm::vec3 a = color(prefiltered, x, y), b = color(harmonics.image, x, y);
                squares += glm::dot(a - b, a - b) / (glm::dot(a, a) + 1e-4);
            }
        }
        const double error = std::sqrt(squares / (prefiltered.width * prefiltered.height));
        EXPECT_GT(error, 0.0) << roughness;
        EXPECT_LT(error, 3e-3) << roughness;
    }
}
