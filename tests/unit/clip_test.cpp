// Key frames compared with arithmetic; scenes with hand-made clips.
#include "scene/animation.h"
#include "scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include <array>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

using testing::ElementsAre;

std::vector<double> at(const Track& track, double time) {
    std::vector<double> out(track.components());
    sample(track, time, out);
    return out;
}

Track moves(Interpolation between, std::vector<float> times, std::vector<float> values) {
    return {AnimatedProperty::translation, 0, between, std::move(times), std::move(values)};
}

TEST(Clip, StepsHoldTheLastKey) {
    const Track t = moves(Interpolation::step, {1, 2, 4}, {1, 0, 0, 5, 0, 0, 9, 0, 0});
    EXPECT_EQ(at(t, 0.0)[0], 1.0) << "before the first key";
    EXPECT_EQ(at(t, 1.999)[0], 1.0);
    EXPECT_EQ(at(t, 2.0)[0], 5.0);
    EXPECT_EQ(at(t, 3.999)[0], 5.0);
    EXPECT_EQ(at(t, 4.0)[0], 9.0);
    EXPECT_EQ(at(t, 99.0)[0], 9.0) << "behind the last key";
}

TEST(Clip, LinesRunStraight) {
    const Track t = moves(Interpolation::linear, {1, 3}, {1, 10, 0, 5, -10, 2});
    EXPECT_THAT(at(t, 0.5), ElementsAre(1, 10, 0));
    EXPECT_THAT(at(t, 1.5), ElementsAre(2, 5, 0.5));
    EXPECT_THAT(at(t, 2.0), ElementsAre(3, 0, 1));
    EXPECT_THAT(at(t, 3.5), ElementsAre(5, -10, 2));
}

// A cubic is reproduced exactly from its values and slopes, for any step: t^3 - 2 t on 1..4.
TEST(Clip, SplinesFollowACubicExactly) {
    const auto value = [](float t) { return t * t * t - 2 * t; };
    const auto slope = [](float t) { return 3 * t * t - 2; };
    std::vector<float> values;
    for (const float t : {1.0f, 4.0f}) {
        // The unused ends must not matter.
        for (const float v : {t > 1 ? slope(t) : 77.0f, value(t), t > 1 ? 77.0f : slope(t)}) {
            values.insert(values.end(), {v, 0, 0});
        }
    }
    const Track t = moves(Interpolation::cubicSpline, {1, 4}, values);
    for (const double time : {1.0, 1.25, 2.0, 2.5, 3.9, 4.0}) {
        EXPECT_NEAR(at(t, time)[0], time * time * time - 2 * time, 1e-9) << time;
    }
    EXPECT_EQ(at(t, 0.0)[0], -1.0);
    EXPECT_EQ(at(t, 9.0)[0], 56.0);
}

TEST(Clip, RotationsTurnEvenlyTheShorterWay) {
    const auto half = [](double degrees) { return float(glm::radians(degrees) / 2); };
    // From 10 degrees about y to 100, the second quaternion written with its opposite sign.
    Track t{AnimatedProperty::rotation,
            0,
            Interpolation::linear,
            {0, 1},
            {0, std::sin(half(10)), 0, std::cos(half(10)), 0, -std::sin(half(100)), 0,
             -std::cos(half(100))}};
    for (const double s : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0}) {
        const auto q = at(t, s);
        const double degrees = 10 + 90 * s;
        const double sign = q[3] < 0 ? -1 : 1;
        EXPECT_NEAR(sign * q[1], std::sin(glm::radians(degrees) / 2), 1e-7) << s;
        EXPECT_NEAR(sign * q[3], std::cos(glm::radians(degrees) / 2), 1e-7) << s;
    }
}

TEST(Clip, SplinesOfRotationsAreOfUnitLength) {
    Track t{AnimatedProperty::rotation, 0, Interpolation::cubicSpline, {0, 1}, {}};
    t.values = {0, 0, 0, 0, 0, 0, 0, 1, 3, 0, 0, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
    for (double s = 0; s <= 1; s += 0.125) {
        const auto q = at(t, s);
        EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-12) << s;
    }
    t.values.assign(24, 0.0f);
    EXPECT_THAT(at(t, 0.5), ElementsAre(0, 0, 0, 1)) << "no direction is no rotation";
}

TEST(Clip, TwoKeysAtOneTimeAreAJump) {
    const Track t =
        moves(Interpolation::linear, {0, 1, 1, 2}, {0, 0, 0, 1, 0, 0, 5, 0, 0, 6, 0, 0});
    ASSERT_TRUE(isValid(t, 1));
    EXPECT_NEAR(at(t, 0.999999)[0], 1.0, 1e-5);
    EXPECT_EQ(at(t, 1.0)[0], 5.0);
    EXPECT_EQ(at(t, 1.5)[0], 5.5);
}

TEST(Clip, InvalidClipsAreDetected) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Track good = moves(Interpolation::linear, {0, 1}, {0, 0, 0, 1, 1, 1});
    EXPECT_TRUE(isValid(good, 1));
    EXPECT_FALSE(isValid(good, 0)) << "nothing moves";
    const auto changed = [&](auto&& change) {
        Track t = good;
        change(t);
        return isValid(t, 1);
    };
    EXPECT_FALSE(changed([](Track& t) { t.times = {1, 0}; }));
    EXPECT_FALSE(changed([](Track& t) { t.times = {-1, 0}; }));
    EXPECT_FALSE(changed([&](Track& t) { t.times = {0, nan}; }));
    EXPECT_FALSE(changed([&](Track& t) { t.times = {nan, 1}; }));
    EXPECT_FALSE(changed([&](Track& t) { t.values[4] = nan; }));
    EXPECT_FALSE(changed([](Track& t) { t.values[4] = 1e30f; }));
    EXPECT_FALSE(changed([](Track& t) { t.values.pop_back(); }));
    EXPECT_FALSE(changed([](Track& t) { t.times.clear(); }));
    EXPECT_FALSE(changed([](Track& t) { t.property = AnimatedProperty::rotation; }));
    EXPECT_FALSE(changed([](Track& t) { t.interpolation = Interpolation::cubicSpline; }));
}

TEST(Clip, RepeatsAfterItsEnd) {
    const Clip clip{.name = "c", .duration = 2.0};
    EXPECT_EQ(localTime(clip, 1.5), 1.5);
    EXPECT_EQ(localTime(clip, 2.0), 2.0) << "its end is detectable";
    EXPECT_EQ(localTime(clip, 2.5), 0.5);
    EXPECT_EQ(localTime(clip, 1e6 + 0.25), 0.25);
    EXPECT_EQ(localTime(clip, -3.0), 0.0);
    EXPECT_EQ(localTime({.name = "still"}, 5.0), 0.0);
}

// A parent that turns about y and a child 2 m out along x that shrinks to nothing.
Scene mobile() {
    Scene scene;
    scene.nodes = {{"parent", kNone, glm::dmat4(1.0)}, {"child", 0, glm::dmat4(1.0)}};
    Transform out;
    out.translation = {2, 0, 0};
    scene.nodes[1].parentFromLocal = matrixOf(out);
    scene.movingNodes = {{0, {}}, {1, out}};
    const float h = std::sqrt(0.5f);
    scene.clips = {
        {"turn",
         1.0,
         {{AnimatedProperty::rotation,
           0,
           Interpolation::linear,
           {0, 1},
           {0, 0, 0, 1, 0, h, 0, h}}}},
        {"turn back",
         1.0,
         {{AnimatedProperty::rotation,
           0,
           Interpolation::linear,
           {0, 1},
           {0, h, 0, h, 0, 0, 0, 1}}}},
        {"shrink",
         2.0,
         {{AnimatedProperty::scale, 1, Interpolation::linear, {0, 2}, {1, 1, 1, 0, 0, 0}}}}};
    return scene;
}

TEST(Clip, ChildrenFollowTheirParents) {
    const Scene scene = mobile();
    const Index turn = 0;
    const Pose pose = poseAt(scene, std::span(&turn, 1), 1.0);
    const glm::dvec3 child(pose.worldFromNode[1][3]);
    EXPECT_LT(glm::distance(child, glm::dvec3(0, 0, -2)), 1e-6) << "x turns to -z about y";
    EXPECT_EQ(restPose(scene).worldFromNode[1], scene.nodes[1].parentFromLocal);
}

TEST(Clip, TheFirstClipAndIndependentClipsPlay) {
    const Scene scene = mobile();
    EXPECT_THAT(defaultClips(scene), ElementsAre(0, 2));
    EXPECT_THAT(*clipsNamed(scene, std::nullopt), ElementsAre(0, 2));
    EXPECT_THAT(*clipsNamed(scene, "turn back"), ElementsAre(1));
    EXPECT_THAT(*clipsNamed(scene, ""), ElementsAre());
    EXPECT_FALSE(clipsNamed(scene, "Turn"));
    // Each on its own clock: at 1.5 the rotation has restarted and the child is at a quarter.
    const glm::dmat4 child = poseAt(scene, 1.5).worldFromNode[1];
    EXPECT_NEAR(glm::length(glm::dvec3(child[0])), 0.25, 1e-9);
    EXPECT_NEAR(child[3].x, 2 * std::cos(glm::radians(45.0)), 1e-6);
}

TEST(Clip, ZeroScaleKeepsAnInverse) {
    const Scene scene = mobile();
    const glm::dmat4 child = poseAt(scene, 2.0).worldFromNode[1];
    EXPECT_GT(std::abs(glm::determinant(glm::dmat3(child))), 0.0);
    EXPECT_LT(glm::length(glm::dvec3(child[0])), 1e-5);
    const glm::dmat4 flat = matrixOf({.scale = {2, 0, -3}});
    EXPECT_NEAR(glm::determinant(glm::dmat3(flat)), 2 * 3e-6 * -3, 1e-12);
}

TEST(Clip, EndlessGrowthStaysFinite) {
    Scene scene;
    for (Index i = 0; i < 60; ++i) {
        scene.nodes.push_back({"n", i == 0 ? kNone : i - 1, glm::dmat4(1.0)});
        scene.movingNodes.push_back({i, {}});
    }
    Clip clip{"grow", 1.0, {}};
    for (Index i = 0; i < 60; ++i) {
        clip.tracks.push_back(
            {AnimatedProperty::scale, i, Interpolation::step, {0}, {1e9f, 1e9f, 1e9f}});
    }
    scene.clips = {clip};
    for (const glm::dmat4& m : poseAt(scene, 0.0).worldFromNode) {
        EXPECT_TRUE(std::isfinite(m[0].x) && std::isfinite(m[3].x));
    }
}

// Two triangles' worth of a strip, its upper end bent by a joint and pulled by a target.
Scene bending() {
    Scene scene;
    scene.materials.push_back({});
    scene.nodes = {{"world", kNone, glm::dmat4(1.0)}, {"joint", kNone, glm::dmat4(1.0)}};
    scene.movingNodes = {{1, {}}};
    const float h = std::sqrt(0.5f);
    scene.clips = {
        {"bend",
         1.0,
         {{AnimatedProperty::rotation, 0, Interpolation::linear, {0, 1}, {0, 0, 0, 1, 0, 0, h, h}},
          {AnimatedProperty::weights, 0, Interpolation::linear, {0, 1}, {0, 1}}}}};
    scene.skins = {{{0, 1}, {glm::dmat4(1.0), glm::dmat4(1.0)}}};
    scene.morphWeights = {{0, {0.0f}}};
    for (const glm::vec3 p : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0)}) {
        scene.vertices.push_back({.position = p});
    }
    scene.indices = {0, 1, 2};
    Bounds box;
    for (const Vertex& v : scene.vertices) box.add(v.position);
    scene.clusters = {{0, 3, box}};
    scene.meshes = {{.name = "strip",
                     .clusterCount = 1,
                     .primitives = 1,
                     .area = 0.5,
                     .bounds = box,
                     .deformation = 0}};
    scene.instances = {{0, 0, 0}};
    Deformation d{.skin = 0, .weights = 0, .perVertex = 4};
    for (const Vertex& v : scene.vertices) d.base.push_back({v.position, v.normal, v.tangent});
    // The first stays, the second goes with the joint, the third half.
    for (const float share : {0.0f, 1.0f, 0.5f}) {
        d.influences.insert(d.influences.end(), {{0, 1 - share}, {1, share}, {0, 0}, {0, 0}});
    }
    d.firstDelta = {0, 1};
    d.deltas = {{0, {0, 0, 2}, {1, 0, -1}, {}}};
    scene.deformations = {d};
    finishMotion(scene);
    return scene;
}

TEST(Deformation, MorphTargetsApplyBeforeJoints) {
    const Scene scene = bending();
    EXPECT_THAT(sceneProblems(scene), ElementsAre());
    const Pose pose = poseAt(scene, 1.0);
    const MeshVertices v = verticesOf(scene, pose, scene.meshes[0]);
    const auto near = [](const glm::vec3& a, const glm::vec3& b) {
        return glm::distance(a, b) < 1e-6f;
    };
    EXPECT_TRUE(near(v[0].position, {0, 0, 2})) << "the whole target";
    EXPECT_TRUE(near(v[0].normal, {1, 0, 0})) << "(0, 0, 1) and (1, 0, -1)";
    EXPECT_TRUE(near(v[1].position, {0, 1, 0})) << "x turned to y";
    EXPECT_TRUE(near(v[2].position, {0, 1, 0})) << "between (1, 1, 0) and (-1, 1, 0)";
    EXPECT_TRUE(near(v[1].normal, {0, 0, 1}));
    EXPECT_TRUE(near(boundsOf(pose, scene.meshes[0]).max, {0, 1, 2}));
    EXPECT_TRUE(near(boundsOf(scene, pose, scene.meshes[0], 0).max, {0, 1, 2}));
    EXPECT_NE(pose.deformed[0]->hash, restPose(scene).deformed[0]->hash);
    EXPECT_EQ(poseAt(scene, 0.0).deformed[0]->hash, restPose(scene).deformed[0]->hash);
    EXPECT_GE(scene.reach.max.z, 1.5f) << "its whole motion is part of the bounds";
    EXPECT_EQ(worldBounds(scene, restPose(scene)).max.z, 0.0f);
}

TEST(Deformation, InvalidInputIsRejected) {
    const auto refused = [](auto&& change) {
        Scene scene = bending();
        change(scene);
        return !sceneProblems(scene).empty();
    };
    EXPECT_TRUE(refused([](Scene& s) { s.skins[0].joints[1] = 2; }));
    EXPECT_TRUE(refused([](Scene& s) { s.skins[0].jointFromMesh.pop_back(); }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].influences[0].joint = 2; }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].influences.pop_back(); }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].deltas[0].vertex = 3; }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].firstDelta = {0, 2}; }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].firstVertex = 1; }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].mesh = 1; }));
    EXPECT_TRUE(refused([](Scene& s) { s.deformations[0].weights = 1; }));
    EXPECT_TRUE(refused([](Scene& s) { s.movingNodes[0].node = 2; }));
    EXPECT_TRUE(refused([](Scene& s) { s.clips[0].tracks[0].target = 1; }));
    EXPECT_TRUE(refused([](Scene& s) { s.clips.push_back(s.clips[0]); })) << "one name twice";
    EXPECT_TRUE(refused([](Scene& s) { s.meshes[0].deformation = 1; }));
}

TEST(Deformation, MovingPartsAreListed) {
    const Scene scene = bending();
    EXPECT_THAT(nodesThatMove(scene), ElementsAre(false, true));
    EXPECT_THAT(instancesThatMove(scene), ElementsAre(true));
}

}  // namespace
}  // namespace clerestory
