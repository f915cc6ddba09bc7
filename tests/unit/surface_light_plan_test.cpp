// Whether a frame needs shadows and light between surfaces, and what that light depends on.
#include "plan/effects/surface_light.h"
#include "plan_scenes.h"
#include "scene/convexity.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace clerestory;
using namespace clerestory::test;

namespace {

bool convex(const Scene& scene) {
    return isConvex(scene, restPose(scene));
}

Scene squareScene(bool twoSided) {
    Scene scene;
    place(scene, addSquareMesh(scene, "square", addMaterial(scene, {.doubleSided = twoSided})),
          glm::dvec3(0.0));
    return scene;
}

TEST(Convexity, OneBodyHidesNothing) {
    EXPECT_TRUE(convex(Scene{}));
    EXPECT_TRUE(convex(boxScene()));
    EXPECT_TRUE(convex(squareScene(false)));
    EXPECT_TRUE(convex(squareScene(true)));
    Scene ball;
    const Index mesh = addBallMesh(ball, "ball", addMaterial(ball, {}));
    placeAt(ball, mesh, glm::scale(glm::dmat4(1.0), glm::dvec3(-1e-3, 2.0, 3e3)));
    EXPECT_TRUE(convex(ball)) << "mirrored, thin and large";
}

TEST(Convexity, WhatHidesSomethingIsNotConvex) {
    EXPECT_FALSE(convex(boxScene({.doubleSided = true}))) << "its inside sees itself";
    Scene inwards = boxScene();
    for (std::size_t i = 0; i < inwards.indices.size(); i += 3) {
        std::swap(inwards.indices[i], inwards.indices[i + 1]);
    }
    EXPECT_FALSE(convex(inwards));
    Scene two = boxScene();
    place(two, two.instances.front().mesh, {5.0, 0.0, 0.0});
    EXPECT_FALSE(convex(two));
    Scene below = squareScene(false);  // the box is behind the square
    place(below, addBoxMesh(below, "box", 0), {0.0, 0.0, -3.0});
    EXPECT_FALSE(convex(below)) << "the box sees the square";
}

struct Given {
    Scene scene;
    EnvironmentMap map = [] {
        EnvironmentMap plain = plainMap();
        plain.meanRadiance = 1.0f;
        return plain;
    }();
    FrameRequest request = [] {
        FrameRequest r = lookingFrom({0.0, 0.0, 8.0});
        r.effects = {};
        return r;
    }();

    FrameContext context(const Pose& pose, const ResidentMaps& none, const EnvironmentMaps& maps,
                         const DeviceLimits& limits) const {
        return {.scene = scene,
                .pose = pose,
                .environment = map,
                .maps = maps,
                .resident = none,
                .limits = limits,
                .surfaceLight = 7,
                .light = {.revision = 2, .share = 0.5},
                .convex = convex(scene)};
    }
    LightInputs inputs(double time = 0.0) const {
        const Pose pose = poseAt(scene, time);
        return lightInputs(context(pose, {}, {}, {}), request);
    }
    FramePlan plan() const {
        const Pose pose = poseAt(scene, 0.0);
        return planFrame(context(pose, {}, {}, {}), request);
    }
};

std::string reasonOf(const FramePlan& plan, Effect effect) {
    const auto found = std::find_if(plan.skipped.begin(), plan.skipped.end(),
                                    [&](const Skipped& s) { return s.effect == effect; });
    return found == plan.skipped.end() ? "" : found->reason;
}

Given twoBoxes(Material material = {}) {
    Given given{boxScene(std::move(material))};
    place(given.scene, given.scene.instances.front().mesh, {3.0, 0.0, 0.0});
    return given;
}

Light lamp(Scene& scene, const glm::dvec3& position) {
    const Index node = addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), position));
    return {.name = "lamp", .node = node, .intensity = glm::vec3(10.0f)};
}

TEST(SurfaceLightPlan, BothEffectsAreOnUnlessSwitchedOff) {
    Given given = twoBoxes();
    given.scene.lights.push_back(lamp(given.scene, {0.0, 4.0, 0.0}));
    const FramePlan plan = given.plan();
    EXPECT_EQ(plan.surfaceLight, 7u);
    EXPECT_EQ(plan.light, (LightProgress{.revision = 2, .share = 0.5}));
    EXPECT_NE(plan.shadowMap, kNoTarget);
    given.request.effects.shadows = given.request.effects.indirectLight = false;
    const FramePlan off = given.plan();
    EXPECT_EQ(off.surfaceLight, 0u);
    EXPECT_FALSE(off.light);
    EXPECT_EQ(off.shadowMap, kNoTarget);
}

TEST(SurfaceLightPlan, OneConvexBodyNeedsNeither) {
    Given given{boxScene({.emissive = glm::vec3(1.0f)})};
    given.scene.lights.push_back(lamp(given.scene, {0.0, 4.0, 0.0}));
    const FramePlan plan = given.plan();
    EXPECT_EQ(plan.surfaceLight, 0u);
    EXPECT_EQ(plan.light, (LightProgress{.revision = 0, .share = 1.0})) << "complete as it is";
    EXPECT_EQ(reasonOf(plan, Effect::indirectLight), "no surface faces another");
    EXPECT_EQ(reasonOf(plan, Effect::shadows), "no surface faces another");
    given.request.effects.shadows = given.request.effects.indirectLight = false;
    EXPECT_EQ(given.plan().passes, plan.passes);
}

TEST(SurfaceLightPlan, SomethingMustGiveLight) {
    Given given = twoBoxes();
    EXPECT_EQ(given.inputs().unneeded, "");
    given.request.environment.intensity = 0.0;
    EXPECT_EQ(given.inputs().unneeded, "there is no light source");
    EXPECT_EQ(reasonOf(given.plan(), Effect::indirectLight), "there is no light source");
    Given emitter = twoBoxes({.emissive = glm::vec3(1.0f)});
    emitter.request.environment.intensity = 0.0;
    EXPECT_EQ(emitter.inputs().unneeded, "");
    emitter.request.effects.emission = false;
    EXPECT_EQ(emitter.inputs().unneeded, "there is no light source");
    given.scene.lights.push_back(lamp(given.scene, {0.0, 4.0, 0.0}));
    EXPECT_EQ(given.inputs().unneeded, "");
}

TEST(SurfaceLightPlan, SomethingMustBeLit) {
    Material plain;
    plain.unlit = true;
    EXPECT_EQ(twoBoxes(plain).inputs().unneeded, "no surface is lit");
}

TEST(SurfaceLightPlan, OtherChannelsHaveNone) {
    Given given = twoBoxes();
    for (const Channel channel :
         {Channel::depth, Channel::normal, Channel::objectId, Channel::through}) {
        given.request.output.channel = channel;
        given.request.output.format = OutputFormat::npy;
        const FramePlan plan = given.plan();
        EXPECT_EQ(plan.surfaceLight, 0u);
        EXPECT_FALSE(plan.light);
        EXPECT_EQ(plan.shadowMap, kNoTarget);
    }
}

// Otherwise each time of an animation would be another computation.
TEST(SurfaceLightPlan, LampsThatMoveAreLeftOutOfIt) {
    Given given = twoBoxes();
    const std::uint64_t without = given.inputs().hash;
    given.scene.lights.push_back(lamp(given.scene, {0.0, 4.0, 0.0}));
    const std::uint64_t still = given.inputs().hash;
    EXPECT_NE(still, without);
    const Index node = given.scene.lights.front().node;
    given.scene.movingNodes.push_back({.node = node});
    EXPECT_EQ(given.inputs().hash, without);
    EXPECT_EQ(given.inputs().lights.size(), 0u);
    EXPECT_EQ(reasonOf(given.plan(), Effect::indirectLight),
              "1 light moves: light of moving lights is not reflected between surfaces");
}

}  // namespace
