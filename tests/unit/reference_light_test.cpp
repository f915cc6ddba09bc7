// Images of the reference path tracer whose radiance is known in closed form.
#include "reference_support.h"

#include "reference/bsdf.h"
#include "reference/scene_geometry.h"

namespace clerestory::test {
namespace {

using reference::kPi;

Material plain(float albedo, float metallic, float roughness) {
    return {.baseColor = glm::vec4(glm::vec3(albedo), 1.0f),
            .metallic = metallic,
            .roughness = roughness};
}

// A lossless ball is invisible in uniform light.
TEST(ReferenceFurnace, EnergyIsConservedByOpaqueSurfaces) {
    const EnvironmentMap map = uniformMap(1.0f);
    for (const ReferenceMode mode : {ReferenceMode::effects, ReferenceMode::full}) {
        for (const float metallic : {0.0f, 0.5f, 1.0f}) {
            for (const float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
                SCOPED_TRACE(testing::Message() << int(mode) << " metallic " << metallic
                                                << " roughness " << roughness);
                // One ray at the centre and one at the ball's edge.
                for (const double aside : {0.0, 0.95}) {
                    FrameRequest frame = narrow({aside, 0.0, 5.0}, {aside, 0.0, 0.0}, 0.002);
                    const ReferenceImage image =
                        traced(ballScene(plain(1.0f, metallic, roughness)), frame, map, mode, 1024);
                    ASSERT_EQ(image.objectId.front(), 1u);
                    EXPECT_LT(meanColor(image).y, 1.005);
                    EXPECT_GT(meanColor(image).y, 0.99);
                }
            }
        }
    }
}

// As NormalsThatTurnAwayMirrorNoMoreThanTheFaceLets of the frames: at the foremost point of the
// ball the face looks along z, the normal is 60 degrees from it, and the eye 50 degrees on the
// other side.
TEST(ReferenceFurnace, NormalsThatTurnAwayMirrorNoMoreThanTheFaceLets) {
    for (const float roughness : {0.0f, 0.1f, 0.3f}) {
        Scene scene = ballScene(plain(0.0f, 0.0f, roughness));
        for (Vertex& vertex : scene.vertices) vertex.normal = {0.8660254f, 0.0f, 0.5f};
        const glm::dvec3 foremost{0.0, 0.0, 1.0};
        const FrameRequest frame =
            narrow(foremost + glm::dvec3{-7.660444, 0.0, 6.427876}, foremost, 1e-4);
        const ReferenceImage image =
            traced(scene, frame, uniformMap(1.0f), ReferenceMode::full, 1024);
        EXPECT_LE(meanColor(image).x, 0.18) << roughness;
        EXPECT_GE(meanColor(image).x, 0.08) << roughness;
    }
}

TEST(ReferenceFurnace, GlassLosesNothing) {
    const EnvironmentMap map = uniformMap(1.0f);
    for (const float ior : {1.0f, 1.33f, 1.5f, 3.0f}) {
        for (const float roughness : {0.0f, 0.4f, 1.0f}) {
            for (const float thickness : {0.0f, 1.0f}) {
                SCOPED_TRACE(testing::Message() << ior << " " << roughness << " " << thickness);
                Material glass = plain(1.0f, 0.0f, roughness);
                glass.transmission = 1.0f;
                glass.ior = ior;
                glass.thickness = thickness;
                FrameRequest frame = narrow({0.7, 0.3, 5.0}, {0.7, 0.3, 0.0}, 0.1);
                const ReferenceImage image =
                    traced(ballScene(glass, 48), frame, map, ReferenceMode::effects, 256);
                EXPECT_NEAR(meanColor(image).x, 1.0, 2e-3);
            }
        }
    }
}

// Rough glass scatters the light of a lamp as that of a small emitter of the same power, which
// paths meet: a pane, and a body between two faces.
TEST(ReferenceGlass, ScattersTheLightOfLampsAsThatOfEmitters) {
    constexpr double kRadius = 0.1, kRadiance = 100.0;
    for (const float thickness : {0.0f, 0.4f}) {
        for (const double aside : {0.0, 0.4}) {
            const auto seen = [&](bool emitter) {
                Scene scene;
                scene.id = "glass";
                Material glass = plain(1.0f, 0.0f, 0.5f);
                glass.transmission = 1.0f;
                glass.thickness = thickness;
                MeshDraft wall = shapes::draft("wall", addMaterial(scene, glass));
                shapes::addBox(wall, {-3.0f, -3.0f, -thickness}, {3.0f, 3.0f, 0.0f});
                if (thickness == 0.0f) wall.indices.resize(6);
                placeAt(scene, addMesh(scene, std::move(wall)), glm::dmat4(1.0));
                const glm::dmat4 place =
                    glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, -2.0 - thickness));
                if (emitter) {
                    placeAt(scene,
                            addFineBall(scene, addMaterial(scene, lamp(float(kRadiance))), 32,
                                        float(kRadius)),
                            place);
                } else {
                    scene.lights.push_back(
                        {.node = addNode(scene, "lamp", place),
                         .intensity = glm::vec3(float(kRadiance * kPi * kRadius * kRadius))});
                }
                return meanColor(traced(scene, narrow({aside, 0.0, 6.0}, {0.0, 0.0, 0.0}, 0.05),
                                        uniformMap(0.0f), ReferenceMode::full, 40000, 2))
                    .x;
            };
            const double found = seen(true);
            EXPECT_GT(found, 0.1);
            EXPECT_NEAR(seen(false) / found, 1.0, 0.05) << thickness << ' ' << aside;
        }
    }
}

TEST(ReferenceFurnace, EmissiveClosedBoxSumsItsBounces) {
    Material wall = chalk(0.5f);
    wall.emissive = glm::vec3(0.5f);
    wall.doubleSided = true;
    Scene scene = boxScene(wall);
    const FrameRequest frame = narrow({0.1, 0.2, 0.3}, {1.0, 0.4, -0.5}, 1.2, 8);
    const ReferenceImage full = traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 256);
    EXPECT_NEAR(meanColor(full).x, 1.0, 0.01);  // 0.5 / (1 - 0.5)
    const ReferenceImage effects =
        traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 2);
    EXPECT_FLOAT_EQ(float(meanColor(effects).x), 0.5f);
}

// Light passes the dielectric part alone, so half a metal whose other half is clear reflects half
// of what the metal does, and nothing diffusely.
TEST(ReferenceLights, OnAHalfMetallicTransmittingSurface) {
    const auto lit = [](float metallic) {
        Material m = plain(0.8f, metallic, 0.5f);
        m.specular = 0.0f;
        m.ior = 1.0f;
        m.transmission = 1.0f;
        Scene scene = ballScene(m, 48);
        scene.lights.push_back({.name = "lamp", .node = kNone, .intensity = glm::vec3(20.0f)});
        scene.lights.back().node =
            addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), glm::dvec3(0.5, 0.5, 5.0)));
        const FrameRequest frame = narrow({0.0, 0.0, 5.0}, {0.0, 0.0, 0.0});
        return meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 4096)).x;
    };
    const double whole = lit(1.0f);
    EXPECT_GT(whole, 0.05);
    EXPECT_NEAR(lit(0.5f) / whole, 0.5, 0.02);
}

// Nothing is reflected where the index does not change, at no angle.
TEST(ReferenceLights, OnIndexMatchedSurfaces) {
    const auto lit = [](float ior, float specular) {
        Material m = plain(0.2f, 0.0f, 0.3f);
        m.ior = ior;
        m.specular = specular;
        Scene scene = ballScene(m, 48);
        scene.lights.push_back({.name = "lamp", .node = kNone, .intensity = glm::vec3(20.0f)});
        scene.lights.back().node =
            addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), glm::dvec3(3.0, 0.5, -3.0)));
        const FrameRequest frame = narrow({0.0, 0.0, 5.0}, {0.0, 0.0, 0.0}, 0.5);
        return traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 64).color.data;
    };
    EXPECT_EQ(lit(1.0f, 1.0f), lit(1.0f, 0.0f));
    EXPECT_NE(lit(1.5f, 1.0f), lit(1.5f, 0.0f));
}

// A lamp in the middle of a ball: every bounce is uniform over it.
TEST(ReferenceLights, InAHollowBall) {
    Material wall = chalk(0.6f);
    wall.doubleSided = true;
    Scene scene = ballScene(wall, 128);
    scene.lights.push_back({.name = "lamp", .node = kNone, .intensity = glm::vec3(3.0f)});
    const FrameRequest frame = narrow({0.2, 0.1, 0.0}, {1.0, 0.3, 0.2}, 0.5);
    const double direct = 0.6 * 3.0 / kPi;
    EXPECT_NEAR(
        meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 64)).x / direct,
        1.0, 2e-3);
    EXPECT_NEAR(meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 4096)).x /
                    (direct / (1.0 - 0.6)),
                1.0, 0.01);
}

Scene floorUnder(Index& black) {
    Scene scene;
    scene.id = "floor";
    black = addMaterial(scene, chalk(0.0f));
    const Index floor = addSquareMesh(scene, "floor", addMaterial(scene, chalk(0.8f)));
    placeAt(scene, floor,
            glm::rotate(glm::scale(glm::dmat4(1.0), glm::dvec3(4.0)), -0.5 * kPi, {1, 0, 0}));
    return scene;
}

glm::dmat4 lyingFaceDown(double height, double halfSize) {
    const glm::dmat4 up = glm::translate(glm::dmat4(1.0), {0.0, height, 0.0});
    return glm::rotate(glm::scale(up, glm::dvec3(halfSize)), 0.5 * kPi, {1, 0, 0});
}

// A glowing square straight above a point of the floor: four times the form factor of a corner.
TEST(ReferenceLights, EmissiveSquareLightsTheFloorBelow) {
    Index black = 0;
    Scene scene = floorUnder(black);
    const Index square = addSquareMesh(scene, "lamp", addMaterial(scene, lamp(5.0f)));
    placeAt(scene, square, lyingFaceDown(1.0, 0.5));
    const double a = 0.5, root = std::sqrt(1.0 + a * a);
    const double irradiance = 5.0 * 4.0 * (a / root) * std::atan(a / root);
    const FrameRequest frame = narrow({2.0, 0.8, 0.0}, {0.0, 0.0, 0.0}, 0.005);
    const double full =
        meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 4096)).x;
    EXPECT_NEAR(full / (0.8 * irradiance / kPi), 1.0, 0.01);
    EXPECT_EQ(meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 2)).x, 0.0);
}

// Next to a low emitter, where light leaves it and arrives at small angles: the integral over it.
TEST(ReferenceLights, AnEmitterCloseToAFloorLightsItAtSmallAngles) {
    constexpr double kHeight = 0.05;
    Index black = 0;
    Scene scene = floorUnder(black);
    const Index square = addSquareMesh(scene, "lamp", addMaterial(scene, lamp(5.0f)));
    placeAt(scene, square, lyingFaceDown(kHeight, 0.5));
    for (const double aside : {0.6, 0.8, 1.2}) {
        double irradiance = 0.0;
        constexpr int kSteps = 400;
        for (int i = 0; i < kSteps * kSteps; ++i) {
            const double x = (i % kSteps + 0.5) / kSteps - 0.5,
                         z = (i / kSteps + 0.5) / kSteps - 0.5;
            const double squared = (x - aside) * (x - aside) + z * z + kHeight * kHeight;
            irradiance += 5.0 * kHeight * kHeight / (squared * squared) / (kSteps * kSteps);
        }
        const FrameRequest frame = narrow({aside, 3.0, 0.01}, {aside, 0.0, 0.0}, 0.002);
        const double seen =
            meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 16384)).x;
        EXPECT_NEAR(seen / (0.8 * irradiance / kPi), 1.0, 0.03) << aside;
    }
}

// Between two large plates at a small distance each sees the other only. With albedo a and one
// plate that emits e, the plates have e / (1 - a^2) and a e / (1 - a^2).
TEST(ReferenceLights, ACorridorOfTwoGreyWallsHasItsSeries) {
    Scene scene;
    Material dull = chalk(0.5f), bright = chalk(0.5f);
    bright.emissive = glm::vec3(0.3f);
    dull.doubleSided = bright.doubleSided = true;
    placeAt(scene, addSquareMesh(scene, "dull", addMaterial(scene, dull)),
            lyingFaceDown(0.0, 400.0));
    placeAt(scene, addSquareMesh(scene, "bright", addMaterial(scene, bright)),
            lyingFaceDown(1.0, 400.0));
    const auto seen = [&](double height) {
        const FrameRequest frame = narrow({0.0, 0.5, 0.0}, {0.1, height, 0.0}, 0.005);
        return meanColor(traced(scene, frame, uniformMap(1.0f), ReferenceMode::full, 4096)).x;
    };
    EXPECT_NEAR(seen(0.0), 0.2, 0.004);
    EXPECT_NEAR(seen(1.0), 0.4, 0.004);
}

TEST(ReferenceLights, CastsShadowsInModeFullOnly) {
    Index black = 0;
    Scene scene = floorUnder(black);
    placeAt(scene, addSquareMesh(scene, "shade", black), lyingFaceDown(0.5, 0.2));
    scene.lights.push_back(
        {.name = "lamp",
         .node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {0.0, 2.0, 0.0})),
         .intensity = glm::vec3(1.0f)});
    scene.materials[black].doubleSided = true;
    const FrameRequest frame = narrow({2.0, 0.4, 0.0}, {0.0, 0.0, 0.0}, 0.005);
    const double lit = 0.8 / 4.0 / kPi;
    EXPECT_NEAR(meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::effects, 4)).x, lit,
                1e-4);
    EXPECT_EQ(meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 64)).x, 0.0);
}

// From the floor, an edge hides the part of a disc that is behind a line.
TEST(ReferenceLights, AnEdgeHidesAPartOfARoundLamp) {
    Index black = 0;
    Scene scene = floorUnder(black);
    placeAt(scene, addSquareMesh(scene, "shade", black),
            glm::translate(glm::dmat4(1.0), {-1.0, 0.0, 0.0}) * lyingFaceDown(0.5, 1.0));
    scene.materials[black].doubleSided = true;
    constexpr double kRadius = 0.3;
    scene.lights.push_back(
        {.name = "lamp",
         .node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {0.0, 2.0, 0.0})),
         .intensity = glm::vec3(1.0f),
         .radius = kRadius});
    const double lit = 0.8 / 4.0 / kPi;
    for (const double x : {-0.05, 0.0, 0.05}) {
        const FrameRequest frame = narrow({2.0, 0.4, 0.0}, {x, 0.0, 0.0}, 0.002);
        const double seen =
            meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 4096)).x;
        // The lamp is three times as far above the edge as the floor is below it.
        const double line = -3.0 * x / kRadius;
        const double share = (std::acos(line) - line * std::sqrt(1.0 - line * line)) / kPi;
        EXPECT_NEAR(seen / lit, share, 0.02) << x;
    }
}

// A mirror stands next to the floor below a lamp: the floor has the light of the lamp and that of
// its image, twice as far away as the mirror.
TEST(ReferenceLights, AFlatMirrorThrowsTheLightOfALamp) {
    constexpr double kLit = 0.8 / kPi;
    constexpr double kTint = 0.9;
    const double root = std::sqrt(5.0);
    const double reflected = kTint + (1.0 - kTint) * std::pow(1.0 - 2.0 / root, 5.0);
    const double thrown = kLit * reflected / (5.0 * root);
    const auto seen = [&](double height, double turn, bool shaded) {
        Index black = 0;
        Scene scene = floorUnder(black);
        scene.materials[black].doubleSided = true;
        const Index silver = addMaterial(
            scene,
            {.name = "silver", .baseColor = glm::vec4(glm::vec3(kTint), 1.0f), .roughness = 0.0f});
        glm::dmat4 stands = glm::translate(glm::dmat4(1.0), {1.0, height, 0.0});
        stands = glm::rotate(stands, turn, {0.0, 1.0, 0.0});
        placeAt(scene, addSquareMesh(scene, "mirror", silver), glm::scale(stands, glm::dvec3(0.2)));
        if (shaded) {
            const glm::dmat4 upright = glm::rotate(
                glm::translate(glm::dmat4(1.0), {0.5, 0.75, 0.0}), 0.5 * kPi, {0, 1, 0});
            placeAt(scene, addSquareMesh(scene, "shade", black),
                    glm::scale(upright, glm::dvec3(0.1)));
        }
        scene.lights.push_back(
            {.name = "lamp",
             .node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {0.0, 1.0, 0.0})),
             .intensity = glm::vec3(1.0f)});
        const FrameRequest frame = narrow({0.0, 0.8, 2.0}, {0.0, 0.0, 0.0}, 0.001);
        return meanColor(traced(scene, frame, uniformMap(0.0f), ReferenceMode::full, 64)).x;
    };
    EXPECT_NEAR(seen(0.5, -0.5 * kPi, false), kLit + thrown, 2e-4);
    EXPECT_NEAR(seen(0.5, 0.5 * kPi, false), kLit, 2e-4);   // it shows its back
    EXPECT_NEAR(seen(0.8, -0.5 * kPi, false), kLit, 2e-4);  // the way passes below it
    EXPECT_NEAR(seen(0.5, -0.5 * kPi, true), kLit, 2e-4);   // the lamp does not reach it there
}

// Two long mirrors face each other; a slanted ray leaves between their ends after k
// reflections.
TEST(ReferenceMirrors, TheKthImageIsReflectedKTimes) {
    Scene scene;
    const Index mirror =
        addSquareMesh(scene, "mirror", addMaterial(scene, plain(0.9f, 1.0f, 0.0f)));
    const glm::dmat4 large = glm::scale(glm::dmat4(1.0), glm::dvec3(10.0, 10.0, 1.0));
    placeAt(scene, mirror, glm::translate(glm::dmat4(1.0), {0, 0, -1}) * large);
    placeAt(scene, mirror,
            glm::rotate(glm::translate(glm::dmat4(1.0), {0, 0, 1}), kPi, {0, 1, 0}) * large);
    for (const int k : {1, 2, 4, 8, 15, 40}) {
        // Reflections lie at slope, 3 slope, 5 slope ...; the k-th is the last within 10.
        const double slope = 10.0 / (2.0 * k);
        const FrameRequest frame = narrow({0, 0, 0}, {slope, 0, -1}, 1e-4);
        const double cosine = 1.0 / std::sqrt(1.0 + slope * slope);
        const double f = 0.9 + 0.1 * std::pow(1.0 - cosine, 5.0);
        const ReferenceImage image =
            traced(scene, frame, uniformMap(1.0f), ReferenceMode::effects, k < 16 ? 2 : 20000);
        EXPECT_NEAR(meanColor(image).x / std::pow(f, k), 1.0, k < 16 ? 1e-4 : 0.02) << k;
    }
}

TEST(ReferenceMirrors, LosslessMirrorsTerminate) {
    Material mirror = plain(1.0f, 1.0f, 0.0f);
    mirror.doubleSided = true;
    const FrameRequest frame = narrow({0.1, 0.2, 0.3}, {1.0, 0.4, -0.5}, 1.2, 4);
    const ReferenceImage image =
        traced(boxScene(mirror), frame, uniformMap(1.0f), ReferenceMode::effects, 16);
    EXPECT_EQ(meanColor(image).x, 0.0);
}

TEST(ReferenceGlass, PanesTransmitTheSeriesOfReflections) {
    for (const double degrees : {0.0, 45.0, 60.0, 75.0}) {
        Scene scene;
        Material glass = plain(1.0f, 0.0f, 0.0f);
        glass.transmission = 1.0f;
        glass.thickness = 0.01f;
        glass.attenuationColor = {0.5f, 0.8f, 1.0f};
        glass.attenuationDistance = 0.02f;
        const Index pane = addSquareMesh(scene, "pane", addMaterial(scene, glass));
        placeAt(scene, pane, glm::rotate(glm::dmat4(1.0), degrees * kPi / 180.0, {0, 1, 0}));
        const Index behind = addSquareMesh(scene, "lamp", addMaterial(scene, lamp(1.0f)));
        placeAt(scene, behind, glm::translate(glm::dmat4(1.0), {0, 0, -3}));
        const ReferenceImage image = traced(scene, narrow({0, 0, 3}, {0, 0, 0}), uniformMap(0.0f),
                                            ReferenceMode::effects, 4096);
        const double c = std::cos(degrees * kPi / 180.0);
        const double within = 0.01 / reference::refractedCosine(c, 1.5);
        const auto expected = reference::paneCoefficients(
            c, 1.5, reference::beerLambert(glass.attenuationColor, 0.02, within));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(meanColor(image)[i], expected.transmitted[i], 0.01) << degrees;
        }
        EXPECT_EQ(image.firstHit.front(), FirstHit::glass);
    }
}

// Radiance that encodes its direction: a sky of 0.5 + 0.5 d.
EnvironmentMap compass() {
    EnvironmentMap map{.name = "compass", .faceSize = 128};
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x) {
                map.texels.push_back(
                    0.5f + 0.5f * glm::normalize(cubeTexelDirection(face, x, y, map.faceSize)));
            }
        }
    }
    completeMap(map);
    return map;
}

// Coverage applies to the whole surface, including its transmission (KHR_materials_transmission).
TEST(ReferenceGlass, CoverageScalesPanes) {
    Scene scene;
    Material black{.name = "black",
                   .baseColor = {0.0f, 0.0f, 0.0f, 0.25f},
                   .metallic = 0.0f,
                   .roughness = 0.0f,
                   .transmission = 1.0f};
    black.alphaMode = AlphaMode::blend;
    placeAt(scene, addSquareMesh(scene, "pane", addMaterial(scene, black)), glm::dmat4(1.0));
    const glm::dvec3 seen = meanColor(traced(scene, narrow({0, 0, 3}, {0, 0, 0}), uniformMap(1.0f),
                                             ReferenceMode::effects, 4096));
    const double mirrored = reference::paneCoefficients(1.0, 1.5, glm::dvec3(1.0)).reflected.x;
    EXPECT_NEAR(seen.x, 0.75 + 0.25 * mirrored, 0.02);
}

// A ball deflects rays by 2 (theta - theta_t), and by pi - 2 theta_t more for every internal
// reflection.
TEST(ReferenceGlass, BallsRefractTwice) {
    Material glass = plain(1.0f, 0.0f, 0.0f);
    glass.transmission = 1.0f;
    glass.thickness = 1.0f;
    const Scene scene = ballScene(glass, 256);
    const EnvironmentMap map = compass();
    for (const double degrees : {10.0, 30.0, 45.0, 60.0, 75.0}) {
        const double in = degrees * kPi / 180.0, offset = std::sin(in);
        const double refracted = std::asin(offset / 1.5);
        const double f = reference::fresnel(std::cos(in), 1.5).mean();
        // The ray goes to -Z and is turned towards -X, for it meets the ball at +X.
        const auto skyAt = [](double turned) {
            return 0.5 + 0.5 * glm::dvec3(-std::sin(turned), 0.0, -std::cos(turned));
        };
        glm::dvec3 expected = f * skyAt(-(kPi - 2.0 * in));
        double share = (1.0 - f) * (1.0 - f);
        for (int bounce = 0; bounce < 20; ++bounce, share *= f) {
            expected += share * skyAt(2.0 * (in - refracted) + bounce * (kPi - 2.0 * refracted));
        }
        FrameRequest frame = narrow({offset, 0, 10}, {offset, 0, 0}, 2e-4);
        const glm::dvec3 found = meanColor(traced(scene, frame, map, ReferenceMode::effects, 8192));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], 4e-3) << degrees;
    }
}

TEST(ReferenceEffects, SwitchesApply) {
    Scene scene;
    const Index mirror =
        addSquareMesh(scene, "mirror", addMaterial(scene, plain(1.0f, 1.0f, 0.0f)));
    placeAt(scene, mirror, glm::dmat4(1.0));
    Material glow = lamp(3.0f);
    glow.doubleSided = true;
    placeAt(
        scene, addSquareMesh(scene, "lamp", addMaterial(scene, glow)),
        glm::translate(glm::dmat4(1.0), {0, 0, 4}) * glm::scale(glm::dmat4(1.0), glm::dvec3(9)));
    FrameRequest frame = narrow({0, 0, 2}, {0, 0, 0});
    const auto seen = [&] {
        return meanColor(traced(scene, frame, uniformMap(0.25f), ReferenceMode::effects, 2)).x;
    };
    EXPECT_FLOAT_EQ(float(seen()), 3.0f);
    frame.effects.planarReflection = false;
    EXPECT_FLOAT_EQ(float(seen()), 0.25f);  // the environment
    frame.effects.planarReflection = true;
    frame.effects.emission = false;
    EXPECT_FLOAT_EQ(float(seen()), 0.0f);
}

}  // namespace
}  // namespace clerestory::test
