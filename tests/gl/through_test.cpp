// The channel `through`, compared with object ids and the plan's decisions.
#include "support.h"

#include <map>

namespace clerestory::test {
namespace {

class ThroughChannel : public GlTest {};

Material metal() {
    return {.name = "metal", .metallic = 1.0f, .roughness = 0.0f};
}

// Ids 1 and 2: mirrors in two planes; 3: a ball; 4: a pane; 5: paper; 6: in the plane of 1.
FrameRequest gallery() {
    Scene scene;
    const Index mirror = addMaterial(scene, metal());
    const Index pane = addMaterial(
        scene, {.name = "pane", .metallic = 0.0f, .roughness = 0.0f, .transmission = 1.0f});
    const Index paper = addMaterial(scene, {.name = "paper", .metallic = 0.0f, .roughness = 1.0f});
    place(scene, quad(0.4f, mirror), moved(-1.2, 0.7, 0.0));
    scene.nodes.back().name = "left";
    place(scene, quad(0.4f, mirror), moved(1.2, 0.7, -0.5));
    scene.nodes.back().name = "right";
    place(scene, sphere(0.4f, 12, mirror), moved(0.0, 0.7, 0.0));
    place(scene, quad(0.4f, pane), moved(-0.9, -0.8, 0.25));
    place(scene, quad(0.4f, paper), moved(0.0, -0.8, 0.1));
    place(scene, quad(0.4f, mirror), moved(1.2, -0.7, 0.0));
    FrameRequest r = request(std::move(scene), "gallery");
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.probeSize = 16;
    return r;
}

// The technique of each id; fails if one id has two.
std::map<float, float> seenAs(FrameRequest r) {
    r.output.channel = Channel::objectId;
    const Image ids = renderer().render(r).image;
    r.output.channel = Channel::through;
    const Image through = renderer().render(r).image;
    EXPECT_EQ(through.channels, 1u);
    std::map<float, float> result;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const float id = number(ids, x, y), is = number(through, x, y);
            const auto [known, isNew] = result.try_emplace(id, is);
            EXPECT_EQ(known->second, is) << "id " << id << " at " << x << ", " << y;
        }
    }
    return result;
}

using Answers = std::map<float, float>;

}  // namespace

TEST_F(ThroughChannel, EverySurfaceShowsItsPlannedTechnique) {
    const FrameRequest r = gallery();
    EXPECT_EQ(seenAs(r), (Answers{{0, 0}, {1, 16}, {2, 17}, {3, 3}, {4, 2}, {5, 1}, {6, 16}}));

    // The k-th mirrored picture is that of the k-th decision for one.
    float k = 16.0f;
    std::map<std::string, float> numbers;
    for (const Decision& decision : renderer().plan(r).decisions) {
        if (decision.taken == Method::mirror) numbers[decision.name] = k++;
    }
    EXPECT_EQ(numbers["mirror:left"], 16.0f);
    EXPECT_EQ(numbers["mirror:right"], 17.0f);
}

TEST_F(ThroughChannel, MirrorsWithoutAMirroredViewShowTheEnvironmentMap) {
    FrameRequest r = gallery();
    r.accuracy.planar = PlanarMethod::environment;
    r.accuracy.curved = CurvedMethod::environment;
    r.accuracy.glass = GlassMethod::environment;
    const Answers plain{{0, 0}, {1, 4}, {2, 4}, {3, 4}, {4, 2}, {5, 1}, {6, 4}};
    EXPECT_EQ(seenAs(r), plain) << "glass is glass with every technique";
    r = gallery();
    r.effects.planarReflection = false;
    r.effects.environmentReflection = false;
    EXPECT_EQ(seenAs(r), plain);
    r.effects.refraction = false;
    EXPECT_NE(seenAs(r)[4], 2.0f);
}

TEST_F(ThroughChannel, UsesTheDecisionsOfTheColourChannel) {
    FrameRequest r = gallery();
    const FramePlan color = renderer().plan(r);
    r.output.channel = Channel::through;
    const FramePlan through = renderer().plan(r);
    EXPECT_EQ(through.decisions, color.decisions);
    ASSERT_EQ(through.passes.size(), 1u);
    EXPECT_EQ(through.passes.front().kind(), "channel");
    EXPECT_EQ(through.targets.size(), 1u);
    EXPECT_GT(color.passes.size(), 6u);
}

}  // namespace clerestory::test
