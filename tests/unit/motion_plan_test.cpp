// Effects of moving objects on plans: maps that cannot see them stay resident, bounds follow them,
// and static objects cost what they did.
#include "view_planner_support.h"

namespace clerestory::test {
namespace {

// The instance's node goes from where it is to `to` within a second.
void letMove(Scene& scene, Index instance, const glm::dvec3& to) {
    const Index node = scene.instances[instance].node;
    const glm::dmat4& rest = scene.nodes[node].parentFromLocal;
    const glm::vec3 from(rest[3]);
    scene.movingNodes.push_back(
        {node,
         {.translation = glm::dvec3(from), .scale = glm::dvec3(glm::length(glm::dvec3(rest[0])))}});
    const glm::vec3 end(to);
    Clip clip{"go " + std::to_string(scene.clips.size()), 1.0, {}};
    clip.tracks.push_back({AnimatedProperty::translation,
                           static_cast<Index>(scene.movingNodes.size() - 1),
                           Interpolation::linear,
                           {0, 1},
                           {from.x, from.y, from.z, end.x, end.y, end.z}});
    scene.clips.push_back(clip);
    finishMotion(scene);
    updateContentHash(scene);
}

// A mirror ball to the left and one to the right of a wall, and a box on the left.
Scene twoRooms(const glm::dvec3& boxAt = {-1.5, 0, 2}) {
    Scene scene;
    const Index ball = addBallMesh(scene, "ball", addMaterial(scene, mirror()));
    placeAt(scene, ball, at(-4, 0, 0), "left");
    placeAt(scene, ball, at(4, 0, 0), "right");
    Material plaster = dullGrey();
    plaster.doubleSided = true;
    const Index wall = addSquareMesh(scene, "wall", addMaterial(scene, plaster));
    placeAt(scene, wall,
            glm::scale(glm::rotate(glm::dmat4(1.0), glm::half_pi<double>(), {0, 1, 0}),
                       glm::dvec3(30.0, 3.0, 1.0)));
    place(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), boxAt, 0.2);
    updateContentHash(scene);
    return scene;
}

// From above and far, so that both balls are in the picture.
FrameRequest fromAbove(double time) {
    FrameRequest request = forced(lookingFrom({0.1, 18, 12}));
    request.accuracy.generations = 1;
    request.time = time;
    return request;
}

TEST(Motion, OnlyMapsThatSeeMovementAreRedrawn) {
    Scene scene = twoRooms();
    letMove(scene, 3, {-1.5, 0.5, 2.5});
    const FramePlan first = planOf(scene, fromAbove(0.0));
    ASSERT_EQ(count(first, "capture"), 12u) << toText(first);
    const FramePlan second = planOf(scene, fromAbove(1.0), allOf(first));
    ASSERT_EQ(count(second, "capture"), 6u) << toText(second);
    EXPECT_EQ(passesOf(second, "capture")[0].name, "probe:left");
    EXPECT_THAT(second.skipped, skippedAs("probe:right", "resident and unchanged"));
    EXPECT_EQ(count(second, "environment"), 0u);
    // And back: the earlier cube is the true one again, if it is still there.
    const FramePlan third = planOf(scene, fromAbove(0.0), allOf(first));
    EXPECT_EQ(count(third, "capture"), 0u);
}

// The instance's material changes its colour within a second.
void letChange(Scene& scene, Index instance) {
    Clip clip{"paint", 1.0, {}};
    clip.tracks.push_back({AnimatedProperty::material,
                           scene.instances[instance].material,
                           Interpolation::linear,
                           {0, 1},
                           {1, 1, 1, 1, 0, 0, 1, 1},
                           "baseColor"});
    scene.clips.push_back(clip);
    finishMotion(scene);
    updateContentHash(scene);
}

TEST(Motion, OnlyMapsThatSeeAChangedMaterialAreRedrawn) {
    Scene scene = twoRooms();
    scene.instances[3].material = addMaterial(scene, dullGrey());
    letChange(scene, 3);
    const FramePlan first = planOf(scene, fromAbove(0.0));
    ASSERT_EQ(count(first, "capture"), 12u) << toText(first);
    EXPECT_TRUE(first.materials.empty()) << "the clip starts with the material of the file";
    const FramePlan second = planOf(scene, fromAbove(1.0), allOf(first));
    ASSERT_EQ(count(second, "capture"), 6u) << toText(second);
    EXPECT_EQ(passesOf(second, "capture")[0].name, "probe:left");
    EXPECT_THAT(second.skipped, skippedAs("probe:right", "resident and unchanged"));
    ASSERT_EQ(second.materials.size(), 1u);
    EXPECT_EQ(second.materials[0].baseColor, glm::vec4(0, 0, 1, 1));
    EXPECT_EQ(count(planOf(scene, fromAbove(0.0), allOf(first)), "capture"), 0u);
}

TEST(Motion, LightsThatChangeRedrawWhatTheyLight) {
    Scene scene = twoRooms();
    scene.lights.push_back({.node = addNode(scene, "lamp", at(-4, 1, 2)),
                            .intensity = glm::vec3(10.0f),
                            .range = 3.0f});
    scene.animatedLights.push_back({0, {.intensity = 10.0f, .range = 3.0f}});
    Clip clip{"pulse", 1.0, {}};
    clip.tracks.push_back(
        {AnimatedProperty::light, 0, Interpolation::linear, {0, 1}, {10, 20}, "intensity"});
    scene.clips.push_back(clip);
    finishMotion(scene);
    updateContentHash(scene);
    const FramePlan first = planOf(scene, fromAbove(0.0));
    ASSERT_EQ(first.lights.size(), 1u);
    EXPECT_EQ(first.lights[0].intensity, glm::vec3(10.0f));
    const FramePlan second = planOf(scene, fromAbove(0.5), allOf(first));
    EXPECT_EQ(second.lights[0].intensity, glm::vec3(15.0f));
    EXPECT_GT(count(second, "capture"), 0u);
}

TEST(Motion, HiddenObjectsAreNotDrawn) {
    Scene scene = boxScene();
    Clip clip{"blink", 1.0, {}};
    clip.tracks.push_back(
        {AnimatedProperty::visible, scene.instances[0].node, Interpolation::step, {0, 1}, {1, 0}});
    scene.clips.push_back(clip);
    finishMotion(scene);
    updateContentHash(scene);
    const auto drawn = [&](double time) {
        FrameRequest request = lookingFrom({0, 0, 6});
        request.time = time;
        std::size_t draws = 0;
        for (const Draw& draw : rootOf(planOf(scene, request)).opaqueDraws) {
            draws += draw.instance == 0 ? 1 : 0;
        }
        return draws;
    };
    EXPECT_GT(drawn(0.5), 0u);
    EXPECT_EQ(drawn(1.0), 0u);
}

TEST(Motion, CubesDrawnEveryFrameAreCosted) {
    const auto price = [](const Scene& scene) {
        const FramePlan plan = planOf(scene, fromAbove(0.0));
        for (const Candidate& c : plan.decisions.at(0).candidates) {
            if (c.method == Method::probe) return c.milliseconds;
        }
        return 0.0;
    };
    Scene scene = twoRooms();
    const double still = price(scene);
    letMove(scene, 3, {-1.5, 0.5, 2.5});
    EXPECT_GT(still, 0.0);
    EXPECT_NEAR(price(scene) / still, 16.0, 1e-9) << "a cube of static objects stays resident";
}

TEST(Motion, ObjectsEnteringTheViewAreDrawn) {
    Scene scene = twoRooms();
    letMove(scene, 3, {1.5, 0, 2});  // through the wall
    const FramePlan first = planOf(scene, fromAbove(0.0));
    const FramePlan second = planOf(scene, fromAbove(1.0), allOf(first));
    EXPECT_EQ(count(second, "capture"), 12u) << toText(second);
}

TEST(Motion, FarPlanesBoundMapContents) {
    Scene scene = twoRooms();
    letMove(scene, 3, {-1.5, 0.5, 2.5});
    for (Probe p : {Probe{.name = "near", .position = {-4, 0, 4}, .size = 0.2, .zfar = 1.5},
                    Probe{.name = "far", .position = {-4, 0, 4}, .size = 0.2, .zfar = 15.0}}) {
        scene.probes.push_back(p);
        scene.materials[0].probe = p.name;
        updateContentHash(scene);
        const FramePlan first = planOf(scene, fromAbove(0.0));
        const FramePlan second = planOf(scene, fromAbove(1.0), allOf(first));
        EXPECT_EQ(count(second, "capture"), p.name == "near" ? 0u : 6u) << p.name;
    }
}

TEST(Motion, MovingLightsChangeLitObjects) {
    Scene scene = twoRooms();
    const Index lamp = addNode(scene, "lamp", at(-4, 1, 40));
    scene.lights.push_back({.node = lamp, .intensity = glm::vec3(10.0f), .range = 3.0f});
    addInstance(scene, lamp, scene.instances[3].mesh);
    letMove(scene, static_cast<Index>(scene.instances.size() - 1), {-4, 1, 2});
    const auto captures = [&](double before, double after) {
        const FramePlan first = planOf(scene, fromAbove(before));
        return count(planOf(scene, fromAbove(after), allOf(first)), "capture");
    };
    EXPECT_GT(captures(0.0, 1.0), 0u) << "it came near";
}

TEST(Motion, EqualTimesGiveEqualPlans) {
    Scene scene = twoRooms();
    letMove(scene, 3, {-1.5, 0.5, 2.5});
    EXPECT_EQ(planOf(scene, fromAbove(0.25)), planOf(scene, fromAbove(2.25)))
        << "a clip of one second repeats";
    FrameRequest resting = fromAbove(0.7);
    resting.clip = "";
    const FramePlan rest = planOf(scene, restPose(scene), resting);
    EXPECT_EQ(rest, planOf(scene, fromAbove(0.0)));
}

// Near and far planes, parallax boxes and shares of the scene must not move with what moves.
TEST(Motion, SceneScaledValuesAreConstantOverTime) {
    Scene scene = twoRooms();
    letMove(scene, 3, {-25, 0, 25});
    const FramePlan a = planOf(scene, fromAbove(0.0)), b = planOf(scene, fromAbove(1.0));
    EXPECT_EQ(a.inverseDiagonal, b.inverseDiagonal);
    EXPECT_EQ(rootOf(a).view, rootOf(b).view);
    ASSERT_EQ(rootOf(a).reflections.size(), rootOf(b).reflections.size());
    for (std::size_t i = 0; i < rootOf(a).reflections.size(); ++i) {
        EXPECT_EQ(rootOf(a).reflections[i].proxyMin, rootOf(b).reflections[i].proxyMin);
        EXPECT_EQ(rootOf(a).reflections[i].proxyMax, rootOf(b).reflections[i].proxyMax);
    }
}

TEST(Motion, StaticScenesIgnoreTime) {
    const Scene scene = twoRooms();
    const FramePlan first = planOf(scene, fromAbove(0.0));
    EXPECT_EQ(planOf(scene, fromAbove(7.5)), first);
    EXPECT_EQ(count(planOf(scene, fromAbove(7.5), allOf(first)), "capture"), 0u);
}

TEST(Motion, CullingFollowsMovement) {
    Scene scene = boxScene();
    letMove(scene, 0, {50, 0, 0});
    const auto drawn = [&](double time) {
        FrameRequest request = lookingFrom({0, 0, 6});
        request.time = time;
        return rootOf(planOf(scene, request)).opaqueDraws.size();
    };
    EXPECT_GT(drawn(0.0), 0u);
    EXPECT_EQ(drawn(1.0), 0u);
    FrameRequest there = lookingFrom({50, 0, 6}, {50, 0, 0});
    EXPECT_EQ(rootOf(planOf(scene, there)).opaqueDraws.size(), 0u);
    there.time = 1.0;
    EXPECT_GT(rootOf(planOf(scene, there)).opaqueDraws.size(), 0u);
}

TEST(Motion, UnknownNamesListTheValidOnes) {
    Scene scene = boxScene();
    letMove(scene, 0, {1, 0, 0});
    EXPECT_EQ(unknownClip(scene).pointer, "/clip");
    EXPECT_EQ(unknownClip(scene).allowed, "one of: go 0");
}

}  // namespace
}  // namespace clerestory::test
