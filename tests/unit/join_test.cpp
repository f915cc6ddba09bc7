// Several scenes in one, and patterns of names.
#include "plan_scenes.h"

#include "scene/compose.h"
#include "scene/join.h"
#include "scene/name_pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(NamePattern, StarsStandForAnyCharacters) {
    const struct {
        const char *pattern, *name;
        bool matches;
    } kRows[] = {
        {"lid", "lid", true},     {"lid", "lids", false},      {"lid", "Lid", false},
        {"*", "", true},          {"*", "lid", true},          {"", "", true},
        {"", "lid", false},       {"l*d", "ld", true},         {"l*d", "lid", true},
        {"l*d", "lidded", true},  {"l*d", "lids", false},      {"*id*", "lids", true},
        {"**", "lid", true},      {"a*b*c", "aXbXbXc", true},  {"a*b*c", "aXcXb", false},
        {"*ab", "aab", true},     {"wheel *", "wheel", false}, {"wheel *", "wheel 1", true},
        {"/*/x", "/a/b/x", true}, {"*é*", "café noir", true},  {"*a", "aaaaaaab", false},
    };
    for (const auto& row : kRows) {
        EXPECT_EQ(matchesName(row.pattern, row.name), row.matches)
            << row.pattern << " and " << row.name;
    }
    // Many stars take no more steps than the product of the lengths.
    std::string pattern, name(4096, 'a');
    for (int i = 0; i < 128; ++i) pattern += "*a";
    EXPECT_FALSE(matchesName(pattern + "b", name));
}

// A box that slides below a node, with a lamp, a camera, a probe and a variant.
Scene cart() {
    Scene scene;
    scene.materials = {{.name = "steel"}, {.name = "brass", .probe = "middle"}};
    scene.images.push_back({.name = "dots", .width = 1, .height = 1, .levels = 1});
    scene.images[0].texels = {1, 2, 3, 255};
    scene.textures.push_back({.image = 0});
    scene.materials[0].baseColorTexture.texture = 0;
    const Index box = addBoxMesh(scene, "box", 0);
    const Index base = addNode(scene, "base", glm::translate(glm::dmat4(1), glm::dvec3(2, 0, 0)));
    addInstance(scene, addNode(scene, "", glm::dmat4(1.0), base), box);
    scene.lights.push_back({.name = "lamp", .node = base});
    scene.cameras.push_back({.name = "eye", .node = kNone});
    scene.probes.push_back({.name = "middle", .node = base});
    scene.variants.push_back({"old", {{0, 1}}});
    scene.movingNodes.push_back({base, {}});
    Track slide{.target = 0, .times = {0.0f, 1.0f}, .values = {2, 0, 0, 4, 0, 0}};
    Track hide{.property = AnimatedProperty::visible,
               .target = 1,
               .interpolation = Interpolation::step,
               .times = {0.0f},
               .values = {1}};
    scene.clips.push_back({"roll", 1.0, {slide, hide}});
    finishMotion(scene);
    updateContentHash(scene);
    return scene;
}

TEST(Join, KeepsEverythingOfEachPart) {
    const Scene one = cart();
    const glm::dmat4 up = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 10, 0));
    const Scene both = joined({{&one, "a", glm::dmat4(1.0)}, {&one, "b", up}});
    Scene complete = both;  // but for texels, which joined scenes do not have
    for (TextureImage& image : complete.images) image.texels = one.images[0].texels;
    EXPECT_THAT(sceneProblems(complete), IsEmpty());
    std::vector<std::string> names;
    for (const Node& node : both.nodes) names.push_back(node.name);
    EXPECT_THAT(names, ElementsAre("a", "a/base", "a/", "b", "b/base", "b/"));
    EXPECT_EQ(both.materials[3].name, "b/brass");
    EXPECT_EQ(both.materials[3].probe, "b/middle");
    EXPECT_EQ(both.materials[2].baseColorTexture.texture, 1u);
    EXPECT_EQ(both.lights[1].name, "b/lamp");
    EXPECT_EQ(both.variants[1].name, "b/old");
    EXPECT_EQ(both.variants[1].choices[0].mesh, 1u);
    EXPECT_EQ(triangleCount(both), 2 * triangleCount(one));
    // Both clips play, because they move nothing in common.
    EXPECT_EQ(defaultClips(both).size(), 2u);
    const Pose pose = poseAt(both, 0.5);
    EXPECT_EQ(glm::dvec3(pose.worldFromNode[1][3]), glm::dvec3(3, 0, 0));
    EXPECT_EQ(glm::dvec3(pose.worldFromNode[5][3]), glm::dvec3(3, 10, 0));
    EXPECT_EQ(placeOf(both.lights[1], pose)[3], glm::dvec4(3, 10, 0, 1));
    EXPECT_EQ(glm::dvec3(pose.worldFromNode[both.cameras[1].node][3]), glm::dvec3(0, 10, 0));
    EXPECT_FLOAT_EQ(both.reach.max.y, 11.0f);
    ASSERT_TRUE(both.defaultView);
}

TEST(Join, SkinsFollowTheirPart) {
    Scene scene;
    scene.materials = {{.name = "skin"}};
    const Index joint = addNode(scene, "joint");
    const Index mesh = addBoxMesh(scene, "skinned", 0);
    Deformation d{.mesh = mesh, .firstVertex = 0};
    for (const Vertex& v : scene.vertices) {
        d.base.push_back({v.position, v.normal});
        d.influences.push_back({0, 1.0f});
    }
    scene.skins.push_back({{joint}, {glm::dmat4(1.0)}});
    d.skin = 0;
    d.perVertex = 1;
    scene.deformations.push_back(d);
    scene.meshes[mesh].deformation = 0;
    scene.meshes[mesh].flatPartCount = 0;
    scene.flatParts.clear();
    addInstance(scene, addNode(scene, "skin"), mesh);
    finishMotion(scene);
    const glm::dmat4 turned = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, 7)) *
                              glm::scale(glm::dmat4(1.0), glm::dvec3(2.0));
    const Scene both = joined({{&scene, "a", glm::dmat4(1.0)}, {&scene, "b", turned}});
    EXPECT_THAT(sceneProblems(both), IsEmpty());
    const Pose pose = restPose(both);
    Bounds box =
        transformed(boundsOf(pose, both.meshes[1]), pose.worldFromNode[both.instances[1].node]);
    EXPECT_EQ(box.center(), glm::vec3(0, 0, 7));
    EXPECT_EQ(box.extent(), glm::vec3(4.0f));
}

TEST(Join, HashesFollowThePartsAndTheirPlaces) {
    const Scene one = cart();
    const glm::dmat4 here(1.0), there = glm::translate(here, glm::dvec3(1, 0, 0));
    const std::uint64_t hash = joined({{&one, "a", here}}).contentHash;
    EXPECT_EQ(hash, contentHash({{&one, "a", here}}));
    EXPECT_NE(hash, one.contentHash);
    EXPECT_NE(hash, contentHash({{&one, "b", here}}));
    EXPECT_NE(hash, contentHash({{&one, "a", there}}));
    EXPECT_NE(hash, contentHash({{&one, "a", here}, {&one, "b", here}}));
}

TEST(Join, NamesPartsByTheirIdsAndNumbers) {
    const Scene one = cart();
    const Scene* scenes[] = {&one, &one, &one, &one};
    const std::vector<PlacedScene> placed{{.scene = "cart"},
                                          {.scene = "cart"},
                                          {.scene = "cart", .name = "cart 2"},
                                          {.scene = "box"}};
    std::vector<std::string> names;
    for (const ScenePart& part : scenePartsOf(placed, scenes)) names.push_back(part.name);
    EXPECT_THAT(names, ElementsAre("cart", "cart 3", "cart 2", "box"));
}

TEST(Join, NamesEveryWrongField) {
    PlacedScene flat{.scene = "a", .scale = glm::dvec3(0, 1, 1)}, huge{.scene = "a"},
        twice{.scene = "a", .name = "x"}, empty{.scene = "a", .name = ""};
    huge.matrix = std::array<double, 16>{1e7, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::vector<std::string> pointers;
    for (const FieldError& e : problems({flat, huge, twice, twice, empty})) {
        pointers.push_back(e.pointer);
    }
    EXPECT_THAT(pointers,
                ElementsAre("/scene/0/scale", "/scene/1/matrix", "/scene/3/name", "/scene/4/name"));
}

TEST(Compose, PatternsSelectNodes) {
    Scene scene;
    scene.materials = {{.name = "steel"}};
    const Index box = addBoxMesh(scene, "box", 0);
    for (const char* name : {"wheel 1", "wheel 2", "body"}) {
        addInstance(scene, addNode(scene, name), box);
    }
    updateContentHash(scene);
    NodeOverride wheels{.node = "wheel *", .hidden = true};
    EXPECT_THAT(problems(scene, {wheels}), IsEmpty());
    const Scene without = composed(scene, {{wheels}});
    ASSERT_EQ(without.instances.size(), 1u);
    EXPECT_EQ(without.nodes[without.instances[0].node].name, "body");
    EXPECT_THAT(explained(scene, Composition{{wheels}}),
                ElementsAre("node wheel * (2 nodes): hidden"));
    NodeOverride none{.node = "door *", .hidden = true};
    const auto errors = problems(scene, {none});
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_EQ(errors[0].pointer, "/nodes/0/node");
    EXPECT_THAT(errors[0].detail, HasSubstr("door *"));
}

}  // namespace
}  // namespace clerestory::test
