// Several scenes in one: the same picture as one scene with the nodes of all.
#include "../support/compare_images.h"
#include "support.h"

#include <cmath>

namespace clerestory::test {
namespace {

class JoinTest : public GlTest {};

const glm::dmat4 kTurned =
    moved(0.7, 0.1, 0.2) *
    glm::dmat4(glm::mat3_cast(glm::angleAxis(0.8, glm::dvec3(0.0, 1.0, 0.0))));

// A checkered wall and a mirror on the floor.
void addWall(Scene& s, const glm::dmat4& at) {
    Material checked{.name = "checked", .metallic = 0.0f, .roughness = 0.9f};
    checked.baseColorTexture.texture = addTexture2x2(
        s, {glm::u8vec4(255), {200, 40, 40, 255}, {40, 40, 200, 255}, glm::u8vec4(255)},
        Wrap::repeat);
    place(s, quad(3.0f, addMaterial(s, checked)), at * moved(0, 0, -1.5));
    const glm::dmat4 flat =
        glm::dmat4(glm::mat3_cast(glm::angleAxis(-1.5707963267948966, glm::dvec3(1, 0, 0))));
    place(s, quad(2.0f, addMaterial(s, mirrorMetal(0.9f))), at * moved(0, -1, 0) * flat);
}

// A ball with a texture of its own, which moves, and a lamp.
void addBall(Scene& s, const glm::dmat4& at) {
    Material striped{.name = "striped", .metallic = 0.0f, .roughness = 0.5f};
    striped.baseColorTexture.texture = addTexture2x2(
        s, {glm::u8vec4(20, 200, 20, 255), glm::u8vec4(255), glm::u8vec4(255), {20, 200, 20, 255}},
        Wrap::repeat);
    MeshDraft ball = quad(0.5f, addMaterial(s, striped));
    place(s, std::move(ball), at);
    addLight(s, {.name = "lamp", .intensity = {6.0f, 5.0f, 4.0f}}, at * moved(-0.5, 0.8, 1.0));
}

FrameRequest view(FrameRequest r) {
    r.camera.position = glm::dvec3(0.0, 0.3, 3.0);
    r.camera.target = glm::dvec3(0.0, 0.0, 0.0);
    r.camera.yfov = 0.9;
    r.width = 160;
    r.height = 120;
    r.environment.map = "dusk";
    r.effects.shadows = true;
    return r;
}

TEST_F(JoinTest, ShowsWhatOneSceneWithAllNodesShows) {
    Scene wall, ball, both;
    addWall(wall, glm::dmat4(1.0));
    addBall(ball, glm::dmat4(1.0));
    addWall(both, glm::dmat4(1.0));
    addBall(both, kTurned);
    const FrameRequest first = view(request(wall, "part wall")),
                       second = view(request(ball, "part ball")),
                       made = view(request(both, "wall and ball"));
    const Image wallAlone = renderer().render(first).image;
    FrameRequest r = first;
    PlacedScene placed{.scene = "part ball", .matrix = std::array<double, 16>{}};
    for (int i = 0; i < 16; ++i) (*placed.matrix)[i] = kTurned[i / 4][i % 4];
    r.parts = {{.scene = "part wall"}, placed};
    for (const PlanarMethod planar : {PlanarMethod::mirror, PlanarMethod::traced}) {
        r.accuracy.planar = planar;
        FrameRequest one = made;
        one.accuracy.planar = planar;
        EXPECT_TRUE(imagesMatch(renderer().render(r).image, renderer().render(one).image,
                                Tolerance{"float rounding", 2e-3, 0.002}));
    }
    EXPECT_TRUE(imagesMatch(renderer().render(first).image, wallAlone, kExact))
        << "the loaded scenes stay as they are";

    // Made once: no buffers and no textures for another frame.
    const RendererCounters before = renderer().counters();
    r.exposure = 1.0;
    renderer().render(r);
    EXPECT_EQ(renderer().counters().buffersMade, before.buffersMade);
    EXPECT_EQ(renderer().counters().texturesMade, before.texturesMade);
}

TEST_F(JoinTest, NodesOfEachPartHaveItsName) {
    Scene ball;
    addBall(ball, glm::dmat4(1.0));
    FrameRequest r = view(request(ball, "one of two"));
    r.parts = {{.scene = "one of two", .translation = glm::dvec3(-0.6, 0, 0)},
               {.scene = "one of two", .name = "right", .translation = glm::dvec3(0.6, 0, 0)}};
    FrameRequest left = r, alone = r;
    left.nodes = {{.node = "right/*", .hidden = true}};
    alone.parts.pop_back();
    EXPECT_TRUE(
        imagesMatch(renderer().render(left).image, renderer().render(alone).image, kRounding));
    EXPECT_FALSE(
        imagesMatch(renderer().render(r).image, renderer().render(alone).image, kRounding));
    EXPECT_EQ(renderer().plan(left).composition,
              (std::vector<std::string>{"scene one of two: transformed",
                                        "scene one of two as right: transformed",
                                        "node right/* (2 nodes): hidden"}));
}

TEST_F(JoinTest, UnknownScenesAndBadTransformsAreErrors) {
    Scene ball;
    addBall(ball, glm::dmat4(1.0));
    FrameRequest r = view(request(ball, "known"));
    r.parts = {{.scene = "known", .scale = glm::dvec3(1, 0, 1)}, {.scene = "unknown"}};
    try {
        renderer().plan(r);
        FAIL();
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 2u);
        EXPECT_EQ(error.errors()[0].pointer, "/scene/0/scale");
        EXPECT_EQ(error.errors()[1].pointer, "/scene/1/scene");
    }
    r.parts = {{.scene = "known"}, {.scene = "known"}};
    renderer().render(r);
    renderer().removeScene("known");
    EXPECT_THROW(renderer().render(r), InvalidRequest) << "what was made of it goes with it";
}

}  // namespace
}  // namespace clerestory::test
