// Passes that a frame needs: plan rules.
#include "plan_scenes.h"

#include "plan/graph/features.h"

#include <gmock/gmock.h>

namespace clerestory::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string_view> kinds(const FramePlan& plan) {
    std::vector<std::string_view> result;
    for (const Pass& pass : plan.passes) result.push_back(pass.kind());
    return result;
}

const Pass& surfacePassOf(const FramePlan& plan) {
    for (const Pass& pass : plan.passes) {
        if (pass.kind() == "surface") return pass;
    }
    throw std::logic_error("the plan has no surface pass");
}
DrawScene surfaceOf(const FramePlan& plan) {
    return std::get<DrawScene>(surfacePassOf(plan).work);
}

auto skippedAs(const std::string& name, const std::string& reason) {
    return Contains(AllOf(Field(&Skipped::name, name), Field(&Skipped::reason, HasSubstr(reason))));
}

TEST(Plan, AnEmptySceneShowsTheSky) {
    const FramePlan plan = planOf(Scene{}, lookingFrom({0, 0, 5}));
    EXPECT_THAT(kinds(plan), ElementsAre("surface", "toneMap", "edgeFilter"));
    EXPECT_TRUE(surfaceOf(plan).sky);
    EXPECT_EQ(totals(plan).draws, 0u);
    EXPECT_THAT(plan.skipped, skippedAs("environment:plain", "nothing in view is lit"));
}

TEST(Plan, ASceneWithoutReflectorsNeedsOneSurfacePassAndToneMapping) {
    ResidentMaps resident;
    const FramePlan first = planOf(boxScene(), lookingFrom({0, 0, 5}), resident);
    EXPECT_THAT(kinds(first), ElementsAre("environment", "surface", "toneMap", "edgeFilter"));
    resident.keys.insert(first.targets[first.passes[0].target].residentKey);
    const FramePlan second = planOf(boxScene(), lookingFrom({0, 3, 5}), resident);
    EXPECT_THAT(kinds(second), ElementsAre("surface", "toneMap", "edgeFilter"));
    EXPECT_THAT(second.skipped, skippedAs("environment:plain", "resident"));
}

TEST(Plan, EnvironmentAccuracyIsPartOfTheMapKey) {
    FrameRequest request = lookingFrom({0, 0, 5});
    const FramePlan first = planOf(boxScene(), request);
    request.accuracy.environmentSamples *= 2;
    const FramePlan second = planOf(boxScene(), request, {{first.targets[0].residentKey}});
    EXPECT_EQ(second.passes[0].kind(), "environment");
}

TEST(Plan, EqualRequestsGiveEqualPlans) {
    const FrameRequest request = lookingFrom({1, 2, 5});
    EXPECT_EQ(planOf(boxScene(), request), planOf(boxScene(), request));
    FrameRequest other = request;
    other.exposure = 1.0;
    EXPECT_FALSE(planOf(boxScene(), request) == planOf(boxScene(), other));
}

TEST(Plan, ABoxBehindTheCameraIsNotDrawn) {
    const FramePlan plan = planOf(boxScene(), lookingFrom({0, 0, 5}, {0, 0, 10}));
    EXPECT_EQ(totals(plan).draws, 0u);
    EXPECT_THAT(plan.skipped, skippedAs("clusters", "6 of 6"));
}

TEST(Plan, EveryTriangleInViewIsDrawnOnceWithoutAPrepass) {
    const FramePlan plan = planOf(boxScene(), lookingFrom({0, 0, 20}));
    EXPECT_TRUE(surfaceOf(plan).depthDraws.empty());
    EXPECT_EQ(totals(surfacePassOf(plan)).triangles, 12u);
}

TEST(Plan, ManyLayersCallForADepthPrepassThatCoversTheSameTriangles) {
    Scene scene;
    const Index mesh = addBoxMesh(scene, "box", addMaterial(scene, {}));
    for (int i = 0; i < 8; ++i) place(scene, mesh, {0, 0, -0.1 * i});
    const FramePlan plan = planOf(scene, lookingFrom({0, 0, 2.2}, {0, 0, 0}));
    const DrawScene pass = surfaceOf(plan);
    ASSERT_EQ(pass.depthDraws.size(), 8u);
    EXPECT_EQ(pass.opaqueDraws.size(), 8u);
    EXPECT_EQ(pass.depthDraws.front().instance, 0u) << "nearest first";
    EXPECT_THAT(surfacePassOf(plan).reason, HasSubstr("depth first"));
}

TEST(Plan, PoorOccludersAreNotDrawnDepthFirst) {
    Scene scene;
    const Index mesh = addBoxMesh(scene, "box", addMaterial(scene, {}));
    for (int i = 0; i < 8; ++i) place(scene, mesh, {0, 0, -0.1 * i});
    place(scene, mesh, {0, 0, -200});  // some thirty pixels for twelve triangles
    const FramePlan plan = planOf(scene, lookingFrom({0, 0, 2.2}, {0, 0, 0}));
    const DrawScene pass = surfaceOf(plan);
    EXPECT_EQ(pass.opaqueDraws.size(), 9u);
    ASSERT_EQ(pass.depthDraws.size(), 8u);
    for (const Draw& draw : pass.depthDraws) EXPECT_NE(draw.instance, 8u);
}

TEST(Plan, OpaqueNearToFarBlendedFarToNearMaskedLast) {
    Scene scene;
    const Index opaque = addBoxMesh(scene, "opaque", addMaterial(scene, {}));
    const Index masked =
        addBoxMesh(scene, "masked", addMaterial(scene, {.alphaMode = AlphaMode::mask}));
    const Index blended =
        addBoxMesh(scene, "blended", addMaterial(scene, {.alphaMode = AlphaMode::blend}));
    place(scene, masked, {0, 0, 0}, 0.1);
    place(scene, blended, {0, 0, -1}, 0.1);
    place(scene, opaque, {0, 0, -5}, 0.1);
    place(scene, opaque, {0, 0, -3}, 0.1);
    place(scene, blended, {0, 0, -6}, 0.1);
    const FramePlan plan = planOf(scene, lookingFrom({0, 0, 9}, {0, 0, 0}));
    const auto instances = [](const std::vector<Draw>& draws) {
        std::vector<std::uint32_t> result;
        for (const Draw& draw : draws) result.push_back(draw.instance);
        return result;
    };
    EXPECT_THAT(instances(surfaceOf(plan).opaqueDraws), ElementsAre(3, 2, 0));
    EXPECT_THAT(instances(surfaceOf(plan).blendedDraws), ElementsAre(4, 1));
}

TEST(Plan, EmissionIsCompiledInOnlyWhenSwitchedOnAndEmitting) {
    const Material lamp{.emissive = glm::vec3(0.0f, 1.0f, 0.0f), .emissiveStrength = 4.0f};
    FrameRequest request = lookingFrom({0, 0, 5});
    EXPECT_TRUE(surfaceOf(planOf(boxScene(lamp), request)).opaqueDraws[0].features &
                FEATURE_EMISSION);
    EXPECT_THAT(planOf(boxScene(), request).skipped, skippedAs("emission", "no emissive material"));
    request.effects.emission = false;
    const FramePlan off = planOf(boxScene(lamp), request);
    EXPECT_FALSE(surfaceOf(off).opaqueDraws[0].features & FEATURE_EMISSION);
    EXPECT_THAT(off.skipped, skippedAs("emission", "switched off"));
}

TEST(Plan, WithEmissionOffTheDrawsAreThoseOfASceneWithoutIt) {
    const Material lamp{.emissive = glm::vec3(1.0f)};
    FrameRequest request = lookingFrom({0, 0, 5});
    request.effects.emission = false;
    EXPECT_EQ(surfaceOf(planOf(boxScene(lamp), request)), surfaceOf(planOf(boxScene(), request)));
}

TEST(Plan, DrawsListOnlyLightsThatReachThem) {
    Scene scene = boxScene();
    for (const double x : {3.0, 100.0}) {
        scene.lights.push_back(
            {.node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {x, 0, 0})),
             .intensity = glm::vec3(5.0f),
             .range = 10.0f});
    }
    const Draw draw = surfaceOf(planOf(scene, lookingFrom({0, 0, 5}))).opaqueDraws[0];
    EXPECT_EQ(draw.lights.count, 1u);
    EXPECT_EQ(draw.lights.indices[0], 0u);
    EXPECT_TRUE(draw.features & FEATURE_LIGHTS);
    EXPECT_FALSE(surfaceOf(planOf(boxScene(), lookingFrom({0, 0, 5}))).opaqueDraws[0].features &
                 FEATURE_LIGHTS);
}

TEST(Plan, SpotsThatPointAwayDoNotReach) {
    Scene scene = boxScene();
    for (const double turn : {0.0, 3.14159}) {
        const glm::dmat4 m =
            glm::rotate(glm::translate(glm::dmat4(1.0), {0, 0, 5}), turn, {0, 1, 0});
        scene.lights.push_back({.node = addNode(scene, "spot", m),
                                .kind = LightKind::spot,
                                .intensity = glm::vec3(5.0f),
                                .outerConeAngle = 0.4f});
    }
    const Draw draw = surfaceOf(planOf(scene, lookingFrom({0, 2, 5}))).opaqueDraws[0];
    EXPECT_EQ(draw.lights.count, 1u);
    EXPECT_EQ(draw.lights.indices[0], 0u);
}

TEST(Plan, TheStrongestLightsAreKeptAndTheRestReported) {
    Scene scene = boxScene();
    for (int i = 0; i < 20; ++i) {
        scene.lights.push_back(
            {.node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), {0, 3, 0})),
             .intensity = glm::vec3(i < 10 ? 1.0f : 2.0f)});
    }
    const FramePlan plan = planOf(scene, lookingFrom({0, 0, 5}));
    const LightList lights = surfaceOf(plan).opaqueDraws[0].lights;
    EXPECT_EQ(lights.count, kMaxLightsPerDraw);
    for (std::uint8_t strong = 10; strong < 20; ++strong) {
        EXPECT_THAT(lights.indices, Contains(strong));
    }
    EXPECT_THAT(plan.skipped, skippedAs("lights", "20 lights reach one draw"));
}

TEST(Plan, TheSunRotatesWithItsMap) {
    EnvironmentMap map = plainMap();
    map.sun = Sun{glm::vec3(1, 0, 0), glm::vec3(3.0f)};
    FrameRequest request = lookingFrom({0, 0, 5});
    request.environment.rotation = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};  // +X -> -Z
    request.environment.intensity = 2.0;
    const FramePlan plan = planOf(boxScene(), request, {}, map);
    ASSERT_EQ(plan.lights.size(), 1u);
    EXPECT_NEAR(plan.lights[0].toLight.z, -1.0f, 1e-6f);
    EXPECT_FLOAT_EQ(plan.lights[0].intensity.x, 6.0f);
}

TEST(Plan, LinearRadianceIsNotToneMapped) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.output.format = OutputFormat::npy;
    const FramePlan plan = planOf(boxScene(), request);
    EXPECT_THAT(kinds(plan), Not(Contains("toneMap")));
    EXPECT_EQ(plan.targets[plan.output].format, Format::rgba32f);
}

TEST(Plan, DataChannelsDrawNoEnvironment) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.output = {.format = OutputFormat::npy, .channel = Channel::depth};
    const FramePlan plan = planOf(boxScene(), request);
    EXPECT_THAT(kinds(plan), ElementsAre("channel"));
    EXPECT_EQ(totals(plan).triangles, 12u);
}

TEST(Plan, EveryPassAndEverySkipHasAReason) {
    const FramePlan plan = planOf(boxScene(), lookingFrom({0, 0, 5}));
    for (const Pass& pass : plan.passes) EXPECT_FALSE(pass.reason.empty()) << pass.name;
    for (const Skipped& skipped : plan.skipped)
        EXPECT_FALSE(skipped.reason.empty()) << skipped.name;
    EXPECT_THAT(toText(plan), HasSubstr("total 4 passes, 1 views, 1 draws, 12 triangles"));
}

TEST(Plan, UnknownCamerasListTheExistingOnes) {
    Scene scene = boxScene();
    scene.cameras.push_back({.name = "front", .node = 0});
    FrameRequest request;
    request.camera.name = "back";
    try {
        planOf(scene, request);
        FAIL() << "accepted a camera that does not exist";
    } catch (const InvalidRequest& e) {
        ASSERT_EQ(e.errors().size(), 1u);
        EXPECT_EQ(e.errors()[0].pointer, "/camera/name");
        EXPECT_THAT(e.errors()[0].allowed, HasSubstr("front"));
    }
}

// Whether the box of this material is drawn with the harmonics of the environment.
bool mirrorsHarmonics(const Material& material, const EnvironmentMap& map, Preset preset) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.accuracy = accuracyOf(preset);
    const FramePlan plan = planOf(boxScene(material), request, {}, map);
    return (surfaceOf(plan).opaqueDraws[0].features & FEATURE_WIDE_LOBE) != 0;
}

TEST(PlanFrame, WideLobesMirrorHarmonicsWithinTheTolerance) {
    const EnvironmentMap sky = skyEnvironment(), studio = studioEnvironment();
    Material wall{.metallic = 0.0f, .roughness = 0.8f};
    EXPECT_TRUE(mirrorsHarmonics(wall, sky, Preset::draft));
    EXPECT_TRUE(mirrorsHarmonics(wall, sky, Preset::standard));
    EXPECT_FALSE(mirrorsHarmonics(wall, sky, Preset::fine));
    EXPECT_FALSE(mirrorsHarmonics(wall, studio, Preset::standard));  // has few bright boxes
    EXPECT_TRUE(mirrorsHarmonics(wall, plainMap(), Preset::fine));   // one colour
    Material smooth = wall, metal = wall, black = wall;
    smooth.roughness = 0.5f;
    metal.metallic = 1.0f;
    black.baseColor = {0.0f, 0.0f, 0.0f, 1.0f};  // shows nothing else
    for (const Material& other : {smooth, metal, black}) {
        EXPECT_FALSE(mirrorsHarmonics(other, sky, Preset::standard));
    }
}

}  // namespace
}  // namespace clerestory::test
