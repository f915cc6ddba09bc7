// Composition: nodes hidden, moved and with other materials; lights added, changed and off.
#include "plan_scenes.h"

#include "scene/compose.h"
#include "scene/light_override.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

glm::dmat4 at(double x, double y, double z) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(x, y, z));
}

// base (2, 0, 0) > arm (0, 1, 0) > hand (0, 0, 3); boxes at arm and hand; a lamp at the hand.
Scene robot() {
    Scene scene;
    scene.materials = {{.name = "steel"}, {.name = "brass"}};
    const Index box = addBoxMesh(scene, "box", 0);
    const Index base = addNode(scene, "base", at(2, 0, 0));
    const Index arm = addNode(scene, "arm", at(0, 1, 0), base);
    const Index hand = addNode(scene, "hand", at(0, 0, 3), arm);
    addInstance(scene, arm, box);
    addInstance(scene, hand, box);
    scene.lights.push_back({.name = "lamp", .node = hand, .intensity = {4.0f, 2.0f, 1.0f}});
    updateContentHash(scene);
    return scene;
}

glm::dvec3 placeOf(const Scene& scene, const char* node, double time = 0.0) {
    const Pose pose = poseAt(scene, time);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        if (scene.nodes[i].name == node) return glm::dvec3(pose.worldFromNode[i][3]);
    }
    return glm::dvec3(NAN);
}

NodeOverride of(const char* node) {
    return {.node = node};
}

TEST(Compose, HidesNodesWithEverythingBelow) {
    const Scene scene = robot();
    NodeOverride hand = of("hand");
    hand.hidden = true;
    const Scene without = composed(scene, {{hand}});
    ASSERT_EQ(without.instances.size(), 1u);
    EXPECT_EQ(without.nodes[without.instances[0].node].name, "arm");
    EXPECT_EQ(lightsOf(without, restPose(without))[0].intensity, glm::vec3(0.0f));
    NodeOverride base = of("base");
    base.hidden = true;
    EXPECT_THAT(composed(scene, {{base}}).instances, IsEmpty());
    NodeOverride shown = of("base");
    shown.hidden = false;
    EXPECT_EQ(composed(scene, {{base, shown}}).instances.size(), 2u) << "a later entry wins";
    EXPECT_EQ(scene.instances.size(), 2u) << "the loaded scene stays";
}

TEST(Compose, MovesNodesRelativeToTheirParentOrTheWorld) {
    const Scene scene = robot();
    NodeOverride arm = of("arm");
    arm.translation = glm::dvec3(0, 5, 0);
    Scene moved = composed(scene, {{arm}});
    EXPECT_EQ(placeOf(moved, "arm"), glm::dvec3(2, 5, 0));
    EXPECT_EQ(placeOf(moved, "hand"), glm::dvec3(2, 5, 3));
    arm.relativeTo = Space::world;
    moved = composed(scene, {{arm}});
    EXPECT_EQ(placeOf(moved, "arm"), glm::dvec3(0, 5, 0));
    EXPECT_EQ(placeOf(moved, "hand"), glm::dvec3(0, 5, 3));
    NodeOverride base = of("base");
    base.translation = glm::dvec3(100, 0, 0);
    EXPECT_EQ(placeOf(composed(scene, {{arm, base}}), "arm"), glm::dvec3(0, 5, 0));
    // A quarter turn about +Y takes +Z to +X; the arm's own translation stays.
    NodeOverride turned = of("arm");
    turned.rotation = Quaternion{0, std::sqrt(0.5), 0, std::sqrt(0.5)};
    turned.scale = glm::dvec3(2, 2, 2);
    const glm::dvec3 hand = placeOf(composed(scene, {{turned}}), "hand");
    EXPECT_NEAR(glm::distance(hand, glm::dvec3(8, 1, 0)), 0.0, 1e-12);
    // The same as a matrix, column-major.
    NodeOverride matrix = of("arm");
    matrix.matrix = {0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 1, 0, 1};
    EXPECT_NEAR(glm::distance(placeOf(composed(scene, {{matrix}}), "hand"), hand), 0.0, 1e-12);
}

TEST(Compose, EndsTheAnimationOfWhatItReplaces) {
    Scene scene = robot();
    scene.movingNodes.push_back({1, {.translation = {0, 1, 0}}});
    Track slide{.target = 0, .times = {0.0f, 2.0f}, .values = {0, 1, 0, 8, 1, 0}};
    Track grow{.property = AnimatedProperty::scale,
               .target = 0,
               .times = {0.0f, 2.0f},
               .values = {1, 1, 1, 3, 3, 3}};
    scene.clips.push_back({"slide", 2.0, {slide, grow}});
    finishMotion(scene);
    updateContentHash(scene);
    EXPECT_EQ(placeOf(scene, "hand", 1.0), glm::dvec3(6, 1, 6));
    NodeOverride arm = of("arm");
    arm.translation = glm::dvec3(0, 2, 0);
    EXPECT_EQ(placeOf(composed(scene, {{arm}}), "hand", 1.0), glm::dvec3(2, 2, 6)) << "still grows";
    NodeOverride base = of("base");
    base.translation = glm::dvec3(-1, 0, 0);
    const Scene carried = composed(scene, {{base}});
    EXPECT_EQ(placeOf(carried, "hand", 1.0), glm::dvec3(3, 1, 6)) << "still slides";
    EXPECT_TRUE(carried.reach.min.x <= -2.0f && carried.reach.min.x > -5.0f);
}

TEST(Compose, MovesTheJointsOfSkins) {
    Scene scene = robot();
    Skin skin{.joints = {1}, .jointFromMesh = {glm::inverse(at(2, 1, 0))}};
    scene.skins.push_back(skin);
    const Index mesh = addBoxMesh(scene, "skinned", 0);
    Deformation d{.mesh = mesh, .firstVertex = scene.indices[scene.clusters.back().firstIndex]};
    d.firstVertex = 24;  // the box before it has as many vertices
    for (std::size_t v = d.firstVertex; v < scene.vertices.size(); ++v) {
        d.base.push_back({scene.vertices[v].position, scene.vertices[v].normal});
        d.influences.push_back({0, 1.0f});
    }
    d.skin = 0;
    d.perVertex = 1;
    scene.deformations.push_back(d);
    scene.meshes[mesh].deformation = 0;
    addInstance(scene, addNode(scene, "skin"), mesh);
    finishMotion(scene);
    updateContentHash(scene);
    EXPECT_EQ(scene.meshes[mesh].bounds.center(), glm::vec3(0.0f));
    NodeOverride arm = of("arm");
    arm.translation = glm::dvec3(0, 11, 0);
    const Scene moved = composed(scene, {{arm}});
    EXPECT_EQ(moved.meshes[mesh].bounds.center(), glm::vec3(0, 10, 0));
    EXPECT_EQ(boundsOf(restPose(moved), moved.meshes[mesh]).center(), glm::vec3(0, 10, 0));
}

TEST(Compose, GivesOtherMaterialsThatVariantsDoNotChange) {
    Scene scene = robot();
    scene.materials.push_back({.name = "rust"});
    scene.variants.push_back({"old", {{0, 2}}});
    NodeOverride hand = of("hand");
    hand.material = "brass";
    const Scene plain = composed(scene, {{hand}});
    EXPECT_EQ(plain.instances[0].material, 0u);
    EXPECT_EQ(plain.instances[1].material, 1u);
    const Scene old = composed(scene, {{hand}, "old"});
    EXPECT_EQ(old.instances[0].material, 2u);
    EXPECT_EQ(old.instances[1].material, 1u);
    EXPECT_TRUE(bindMaterials(old, Pose{}, {}, "old").materialOfInstance.empty());
}

TEST(Compose, HashesFollowTheComposition) {
    const Scene scene = robot();
    NodeOverride arm = of("arm");
    arm.translation = glm::dvec3(0, 5, 0);
    const auto hash = [&](const NodeOverride& o) { return composed(scene, {{o}}).contentHash; };
    EXPECT_EQ(hash(arm), hash(arm));
    EXPECT_NE(hash(arm), scene.contentHash);
    NodeOverride other = arm;
    other.relativeTo = Space::world;
    EXPECT_NE(hash(arm), hash(other));
    other = arm;
    other.scale = glm::dvec3(1, 1, 1);
    EXPECT_NE(hash(arm), hash(other));
    EXPECT_EQ(contentHash(scene, Composition{{arm}}), hash(arm));
}

std::vector<std::string> pointersOf(const std::vector<FieldError>& errors) {
    std::vector<std::string> pointers;
    for (const FieldError& e : errors) pointers.push_back(e.pointer);
    return pointers;
}

TEST(Compose, NamesEveryWrongField) {
    const Scene scene = robot();
    NodeOverride unknown = of("hnad"), nothing = of("arm"), flat = of("arm"), huge = of("arm"),
                 both = of("arm"), perspective = of("arm");
    unknown.material = "gold";
    flat.scale = glm::dvec3(1, 0, 1);
    huge.matrix = {1e8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    both.matrix = {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // x and y in one line
    both.translation = glm::dvec3(0);
    perspective.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1};
    const auto errors = problems(scene, {unknown, nothing, flat, huge, both, perspective});
    EXPECT_THAT(
        pointersOf(errors),
        ElementsAre("/nodes/0/node", "/nodes/0/material", "/nodes/1", "/nodes/2/scale",
                    "/nodes/3/matrix", "/nodes/4/matrix", "/nodes/4/matrix", "/nodes/5/matrix"));
    EXPECT_THAT(errors[0].detail, HasSubstr("did you mean \"hand\"?"));
    EXPECT_THAT(errors[4].detail, HasSubstr("too large"));
    EXPECT_THAT(errors[6].detail, HasSubstr("singular"));
    EXPECT_THAT(errors[7].detail, HasSubstr("affine"));
}

TEST(Compose, SaysWhatItChanges) {
    NodeOverride hand = of("hand"), arm = of("arm");
    hand.hidden = true;
    arm.material = "brass";
    arm.translation = glm::dvec3(0);
    EXPECT_THAT(explained(robot(), Composition{{hand, arm}}),
                ElementsAre("node hand: hidden",
                            "node arm: material brass; moved, relative to its parent"));
}

TEST(Lights, AreAddedChangedAndOff) {
    const Scene scene = robot();
    LightOverride brighter{.light = "lamp", .intensity = 8.0},
        bluer{.light = "lamp", .color = glm::dvec3(0, 0, 1)},
        sun{.light = "sun",
            .type = LightKind::directional,
            .color = glm::dvec3(1, 0.5, 0.25),
            .intensity = 2.0,
            .direction = glm::dvec3(0, -3, 0)},
        off{.light = "sun", .enabled = false};
    EXPECT_THAT(problems(scene, {brighter, bluer, sun, off}), IsEmpty());
    std::vector<Light> lights = lightsWith(scene.lights, {brighter});
    EXPECT_EQ(lights[0].intensity, glm::vec3(8, 4, 2));
    lights = lightsWith(scene.lights, {bluer, sun});
    ASSERT_EQ(lights.size(), 2u);
    EXPECT_EQ(lights[0].intensity, glm::vec3(0, 0, 4));
    EXPECT_EQ(lights[1].intensity, glm::vec3(2, 1, 0.5f));
    EXPECT_EQ(placeOf(lights[1], restPose(scene))[2], glm::dvec4(0, 1, 0, 0)) << "towards it";
    EXPECT_EQ(placeOf(lights[0], restPose(scene))[3], glm::dvec4(2, 1, 3, 1)) << "at its node";
    EXPECT_EQ(lightsWith(scene.lights, {sun, off})[1].intensity, glm::vec3(0.0f));
    LightOverride there{.light = "lamp", .position = glm::dvec3(9, 8, 7)};
    EXPECT_EQ(placeOf(lightsWith(scene.lights, {there})[0], restPose(scene))[3],
              glm::dvec4(9, 8, 7, 1));
    LightOverride dark{.enabled = false}, again{.light = "lamp", .enabled = true};
    EXPECT_EQ(lightsWith(scene.lights, {dark})[0].intensity, glm::vec3(0.0f));
    EXPECT_EQ(lightsWith(scene.lights, {dark, again})[0].intensity, glm::vec3(4, 2, 1));
    EXPECT_THAT(explained({brighter, sun, off}),
                ElementsAre("light lamp: changed", "light sun: added, directional",
                            "light sun: changed, off"));
}

TEST(Lights, NameEveryWrongField) {
    const LightOverride nowhere{.type = LightKind::spot}, still{.light = "lamp"},
        unknown{.light = "lmap", .radius = 1.0},
        none{.type = LightKind::directional, .direction = glm::dvec3(0)},
        cone{.light = "lamp", .innerConeAngle = 1.0, .outerConeAngle = 0.5};
    EXPECT_THAT(pointersOf(problems(robot(), {nowhere, still, unknown, none, cone})),
                ElementsAre("/lights/0/position", "/lights/0/direction", "/lights/1",
                            "/lights/2/light", "/lights/3/direction", "/lights/4/innerConeAngle"));
}

}  // namespace
}  // namespace clerestory::test
