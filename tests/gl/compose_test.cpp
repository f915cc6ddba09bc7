// Composed scenes: the picture of a scene whose nodes and lights a request changes equals that of a
// scene that was made so.
#include "../support/compare_images.h"
#include "support.h"

namespace clerestory::test {
namespace {

class ComposeTest : public GlTest {};

struct Parts {
    bool ball = true;
    glm::dvec3 ballAt{-0.4, 0.0, 0.3};
    bool brassBall = false;
    bool lamp = false;
};

// A wall, a mirror on the floor, a metal ball and a box-like quad before it, and a light.
Scene room(const Parts& parts) {
    Scene s;
    const Index plaster = addMaterial(s, {.name = "plaster", .metallic = 0.0f, .roughness = 0.9f});
    Material brass{.name = "brass", .baseColor = {0.9f, 0.6f, 0.2f, 1.0f}, .metallic = 0.0f};
    brass.roughness = 0.7f;
    const Index second = addMaterial(s, brass);
    const Index metal = addMaterial(s, mirrorMetal(0.9f));
    const auto add = [&](const char* name, MeshDraft draft, const glm::dmat4& place) {
        const Index mesh = addMesh(s, std::move(draft));
        addInstance(s, addNode(s, name, place), mesh);
    };
    add("wall", quad(3.0f, plaster), moved(0, 0, -1.5));
    const glm::dmat4 flat =
        moved(0, -1, 0) *
        glm::dmat4(glm::mat3_cast(glm::angleAxis(-1.5707963267948966, glm::dvec3(1, 0, 0))));
    add("floor", quad(2.0f, metal), flat);
    if (parts.ball) {
        add("ball", sphere(0.5f, 24, parts.brassBall ? second : plaster),
            moved(parts.ballAt.x, parts.ballAt.y, parts.ballAt.z));
    }
    add("mirror ball", sphere(0.4f, 24, metal), moved(0.8, -0.3, 0.0));
    const Light sun{.name = "sun", .kind = LightKind::directional, .intensity = glm::vec3(2.0f)};
    const glm::dmat4 slanted(glm::mat3_cast(glm::angleAxis(-0.7, glm::dvec3(1, 0.4, 0))));
    addLight(s, sun, slanted);
    if (parts.lamp) {
        addLight(s, {.name = "lamp", .intensity = {3.0f, 1.5f, 0.75f}}, moved(-1, 0.8, 1));
    }
    return s;
}

FrameRequest roomRequest(const Parts& parts, const std::string& id) {
    FrameRequest r = request(room(parts), id, {0.0, 0.2, 3.0});
    r.width = 160;
    r.height = 120;
    r.camera.yfov = 0.9;
    r.environment.map = "dusk";
    r.effects.shadows = true;
    r.effects.indirectLight = false;
    return r;
}

// Mirrored views, a captured cube or rays, and shadows.
std::vector<FrameRequest> inAllWays(FrameRequest r) {
    std::vector<FrameRequest> list;
    for (const bool rays : {false, true}) {
        r.accuracy.planar = rays ? PlanarMethod::traced : PlanarMethod::mirror;
        r.accuracy.curved = rays ? CurvedMethod::traced : CurvedMethod::probe;
        list.push_back(r);
    }
    return list;
}

void expectSame(const FrameRequest& composed, const FrameRequest& made) {
    const auto first = inAllWays(composed), second = inAllWays(made);
    for (std::size_t i = 0; i < first.size(); ++i) {
        const Frame a = renderer().render(first[i]), b = renderer().render(second[i]);
        EXPECT_TRUE(imagesMatch(a.image, b.image, Tolerance{"float rounding", 2e-3, 0.002}))
            << (i == 0 ? "mirrored view and cube" : "rays");
    }
}

TEST_F(ComposeTest, HiddenNodesAreNowhere) {
    FrameRequest r = roomRequest({}, "room to hide in");
    r.nodes = {{.node = "ball", .hidden = true}};
    expectSame(r, roomRequest({.ball = false}, "room without ball"));
}

TEST_F(ComposeTest, MovedNodesMoveEverywhere) {
    FrameRequest r = roomRequest({}, "room to move in");
    // The loaded scene is drawn before and after.
    const Image before = renderer().render(r).image;
    FrameRequest moved = r;
    moved.nodes = {{.node = "ball", .translation = glm::dvec3(0.1, 0.5, 0.6)}};
    expectSame(moved, roomRequest({.ballAt = {0.1, 0.5, 0.6}}, "room with ball elsewhere"));
    EXPECT_FALSE(imagesMatch(renderer().render(moved).image, before, kExact));
    EXPECT_TRUE(imagesMatch(renderer().render(r).image, before, kExact));
}

TEST_F(ComposeTest, MaterialsAreThoseOfTheScene) {
    FrameRequest r = roomRequest({}, "room to paint");
    r.nodes = {{.node = "ball", .material = "brass"}};
    expectSame(r, roomRequest({.brassBall = true}, "room with brass ball"));
}

TEST_F(ComposeTest, LightsAreAddedAndOff) {
    FrameRequest r = roomRequest({}, "room to light");
    const LightOverride lamp{.light = "lamp",
                             .type = LightKind::point,
                             .color = glm::dvec3(1.0, 0.5, 0.25),
                             .intensity = 3.0,
                             .position = glm::dvec3(-1, 0.8, 1)};
    r.lights = {lamp};
    expectSame(r, roomRequest({.lamp = true}, "room with lamp"));
    FrameRequest off = roomRequest({.lamp = true}, "room with lamp off");
    off.lights = {{.light = "lamp", .enabled = false}};
    expectSame(off, roomRequest({}, "room without lamp"));
}

// Equal compositions share one scene in the renderer, textures belong to the loaded one, and a few
// are kept.
TEST_F(ComposeTest, AreMadeOnceAndBounded) {
    FrameRequest r = roomRequest({}, "room to keep");
    r.nodes = {{.node = "ball", .hidden = true}};
    renderer().render(r);
    renderer().render(r);
    const RendererCounters before = renderer().counters();
    r.exposure = 0.5;
    renderer().render(r);
    EXPECT_EQ(renderer().counters().buffersMade, before.buffersMade);
    EXPECT_EQ(renderer().counters().texturesMade, before.texturesMade);
    const Image first = renderer().render(r).image;
    for (int i = 0; i < 12; ++i) {
        FrameRequest other = r;
        other.nodes = {{.node = "ball", .translation = glm::dvec3(0.05 * i, 0, 0)}};
        renderer().render(other);
    }
    EXPECT_TRUE(imagesMatch(renderer().render(r).image, first, kExact)) << "any history";
    renderer().removeScene("room to keep");
    EXPECT_THROW(renderer().render(r), InvalidRequest);
}

TEST_F(ComposeTest, ThePlanSaysWhatChanged) {
    FrameRequest r = roomRequest({}, "room to explain");
    EXPECT_TRUE(renderer().plan(r).composition.empty());
    r.nodes = {{.node = "ball", .hidden = true}};
    r.lights = {{.light = "sun", .enabled = false}};
    EXPECT_EQ(renderer().plan(r).composition,
              (std::vector<std::string>{"node ball: hidden", "light sun: changed, off"}));
    r.nodes = {{.node = "bell", .hidden = true}};
    try {
        renderer().plan(r);
        FAIL() << "an unknown node is an error";
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 1u);
        EXPECT_EQ(error.errors()[0].pointer, "/nodes/0/node");
    }
}

// Light between surfaces is that of the composed scene.
TEST_F(ComposeTest, IndirectLightIsComputedAgain) {
    FrameRequest r = roomRequest({}, "room to bake");
    r.width = 80;
    r.height = 60;
    r.effects.indirectLight = true;
    renderer().completeLight(r);
    const std::uint64_t computed = renderer().counters().lightsComputed;
    FrameRequest moved = r;
    moved.nodes = {{.node = "ball", .translation = glm::dvec3(0.1, 0.5, 0.6)}};
    EXPECT_TRUE(renderer().completeLight(moved).complete);
    EXPECT_EQ(renderer().counters().lightsComputed, computed + 1);
    FrameRequest made = roomRequest({.ballAt = {0.1, 0.5, 0.6}}, "room baked elsewhere");
    made.width = 80;
    made.height = 60;
    made.effects.indirectLight = true;
    renderer().completeLight(made);
    // Places where light is gathered are chosen at random, by the scene's hash.
    EXPECT_TRUE(imagesMatch(renderer().render(moved).image, renderer().render(made).image,
                            Tolerance{"two samplings of light", 0.1, 0.02}));
}

}  // namespace
}  // namespace clerestory::test
