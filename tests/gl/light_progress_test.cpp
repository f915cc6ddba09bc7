// When light between surfaces is computed, what it depends on, and what does not wait for it.
#include "lit_room.h"
#include "tests/support/soon.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <thread>
#include <utility>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class LightInProgress : public GlTest {};

}  // namespace

TEST_F(LightInProgress, AFrameBeforeTheLightIsThatOfTheEnvironment) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f, 0.25f)));
    FrameRequest r = request(std::move(scene), "before", {0.0, 0.0, 0.5});
    const Frame without = renderer().render(r);
    EXPECT_EQ(without.light.revision, 0u);
    r.effects.indirectLight = true;
    renderer().completeLight(r, [] { return true; });  // begins and does not wait
    const Frame with = renderer().render(lit(r));
    EXPECT_GT(with.light.revision, 0u);
    EXPECT_EQ(with.light.share, 1.0);
    EXPECT_TRUE(sameBytes(renderer().render(r).image, with.image));
    r.effects.indirectLight = false;
    EXPECT_TRUE(sameBytes(renderer().render(r).image, without.image));
}

// While a frame is drawn no round ends, so the first one has revision 0: nothing hides the
// environment, bumps and the backs of sheets included.
TEST_F(LightInProgress, TheFirstFrameShowsTheOpenEnvironment) {
    Scene scene;
    Material sheet = lambert(0.7f);
    sheet.doubleSided = true;
    place(scene, sphere(0.5f, 48, addMaterial(scene, lambert(0.8f))), moved(-0.6, 0.0, 0.0));
    const Index back = addMaterial(scene, sheet);
    place(scene, quad(0.5f, back),
          glm::rotate(moved(0.6, 0.0, 0.0), std::numbers::pi, glm::dvec3(0.3, 1.0, 0.0)));
    FrameRequest r = request(std::move(scene), "open first");
    r.environment.map = "dusk";
    const Image off = renderer().render(r).image;
    r.effects.indirectLight = true;
    const Frame first = renderer().render(r);
    EXPECT_EQ(first.light, LightProgress{});
    ASSERT_TRUE(first.plan.light);
    double greatest = 0.0, brightest = 0.0;
    for (std::size_t i = 0; i < off.data.size() / 4; ++i) {
        greatest = std::max(greatest, double{std::abs(off.floats()[i] - first.image.floats()[i])});
        brightest = std::max(brightest, double{off.floats()[i]});
    }
    // Between vertices the irradiance is linear, and the gloss of the sphere is none.
    EXPECT_LT(greatest, 0.01 * brightest);
}

// Its tables take longer than a frame: the picture does not wait for them.
TEST_F(LightInProgress, AFrameLeavesTheBeginningToWhatFollowsIt) {
    // albedo: that of a light of its own.
    const auto wanted = [&](const std::string& id, float albedo) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(albedo, 0.25f)));
        FrameRequest r = request(std::move(scene), id, {0.0, 0.0, 0.5});
        r.effects = {};
        const Frame first = renderer().render(r);
        EXPECT_TRUE(first.lightNow);
        EXPECT_EQ(first.lightNow(), LightProgress{});
        return std::pair{r, first.lightNow};
    };
    const auto becomesComplete = [](const std::function<LightProgress()>& now) {
        while (now().share < 1.0) std::this_thread::yield();
    };
    renderer().beginNeededLights();  // those of other tests
    const std::uint64_t before = renderer().counters().lightsComputed;
    const auto [r, now] = wanted("begun after it", 0.41f);
    renderer().beginNeededLights();
    becomesComplete(now);
    const auto [next, nextNow] = wanted("begun by the next", 0.42f);
    renderer().render(next);
    becomesComplete(nextNow);
    EXPECT_EQ(renderer().counters().lightsComputed, before + 2);
    const auto removed = wanted("removed before it begins", 0.43f);
    renderer().removeScene(removed.first.scene);
    EXPECT_NO_THROW(renderer().render(r));
    EXPECT_EQ(renderer().counters().lightsComputed, before + 2);
}

// The caller of a renderer knows what is computed, and can have it left out.
TEST_F(LightInProgress, ComputationsAreAnnouncedAndCanBeRefused) {
    std::atomic<int> inProgress{0}, begun{0};
    std::atomic<bool> refuses{false};
    LightOptions options{.threads = 1};
    options.begin = [&](const std::string& scene) -> std::shared_ptr<const void> {
        EXPECT_TRUE(scene == "announced" || scene == "refused");
        if (refuses) return nullptr;
        ++inProgress;
        ++begun;
        return {&begun, [&](const void*) { --inProgress; }};
    };
    Renderer own({.light = options});
    // albedo: that of a light of its own.
    const auto added = [&](const std::string& id, float albedo) {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(albedo, 0.25f)));
        scene.id = id;
        scene.environment = "black";
        updateContentHash(scene);
        own.addScene(std::move(scene));
        FrameRequest r;
        r.scene = id;
        r.width = r.height = 16;
        return r;
    };
    const FrameRequest first = added("announced", 0.5f);
    EXPECT_TRUE(own.completeLight(first).complete);
    EXPECT_EQ(begun, 1);
    EXPECT_TRUE(within(kPatience, [&] { return inProgress == 0; }));
    EXPECT_FALSE(own.render(first).light.failed);

    refuses = true;
    const FrameRequest second = added("refused", 0.6f);
    EXPECT_NE(own.completeLight(second).failure, "");
    const Frame frame = own.render(second);
    EXPECT_EQ(frame.light, (LightProgress{.revision = 0, .share = 0.0, .failed = true}));
    EXPECT_TRUE(frame.lightNow().failed);
    EXPECT_EQ(begun, 1);
}

// A second set would double the time of a cold start.
TEST_F(LightInProgress, FramesBeforeAndAfterTheLightHaveTheSamePrograms) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f, 0.25f)));
    place(scene, sphere(0.3f, 16, addMaterial(scene, mirrorMetal(0.9f, 0.3f))));
    addLight(scene, {.intensity = glm::vec3(2.0f)}, moved(0.0, 0.8, 0.0));
    FrameRequest r = request(std::move(scene), "programs", {0.0, 0.0, 0.9});
    r.effects = {};
    WarmUp warmUp = renderer().beginWarmUp({r});
    while (renderer().advance(warmUp)) {
    }
    const RendererCounters warm = renderer().counters();
    EXPECT_EQ(renderer().render(r).light.revision, 0u);
    const RendererCounters first = renderer().counters();
    EXPECT_EQ(first.programsMade, warm.programsMade);
    const Frame complete = renderer().render(lit(r));
    EXPECT_EQ(complete.light.share, 1.0);
    const RendererCounters last = renderer().counters();
    EXPECT_EQ(last.programsMade, first.programsMade);
    EXPECT_EQ(last.pipelinesMade, first.pipelinesMade);
    EXPECT_EQ(complete.compiled, 0u);
}

// The map shows geometry. Refined meshes are others, so that it is drawn a second time for them.
TEST_F(LightInProgress, ShadowMapsStayWhileTheLightChanges) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f, 0.25f)));
    place(scene, sphere(0.3f, 16, addMaterial(scene, lambert(0.8f))));
    addLight(scene, {.intensity = glm::vec3(2.0f)}, moved(0.0, 0.8, 0.0));
    FrameRequest r = request(std::move(scene), "kept shadows", {0.0, 0.0, 0.9});
    r.effects = {};
    const auto shadowPasses = [&] {
        const Frame frame = renderer().render(r);
        return std::count_if(frame.plan.passes.begin(), frame.plan.passes.end(),
                             [](const Pass& pass) { return pass.kind() == "shadow"; });
    };
    EXPECT_EQ(shadowPasses(), 6);
    EXPECT_EQ(shadowPasses(), 0);
    lit(r);
    EXPECT_EQ(shadowPasses(), 6);
    EXPECT_EQ(shadowPasses(), 0);
    r.environment.map = "dusk";  // other light of the same meshes
    lit(r);
    EXPECT_EQ(shadowPasses(), 0);
}

// Of one convex body nothing is computed, and default requests have the passes, draws, programs and
// bytes of those without both effects.
TEST_F(LightInProgress, WhereNothingHidesTheyCostNothing) {
    Scene scene;
    place(scene, sphere(0.5f, 24, addMaterial(scene, lambert(0.8f, 0.1f))));
    addLight(scene, {.intensity = glm::vec3(2.0f)}, moved(0.0, 2.0, 1.0));
    FrameRequest r = request(std::move(scene), "alone");
    r.environment.map = "dusk";
    renderer().render(r);
    const RendererCounters first = renderer().counters();
    const Frame off = renderer().render(r);
    const RendererCounters before = renderer().counters();
    r.effects = {};
    const Frame on = renderer().render(r);
    const RendererCounters after = renderer().counters();
    EXPECT_EQ(on.plan.passes, off.plan.passes);
    EXPECT_TRUE(sameBytes(on.image, off.image));
    EXPECT_EQ(after.drawCalls - before.drawCalls, before.drawCalls - first.drawCalls);
    EXPECT_EQ(after.programsMade, before.programsMade);
    EXPECT_EQ(after.texturesMade, before.texturesMade);
    EXPECT_EQ(after.lightsComputed, before.lightsComputed);
    EXPECT_EQ(on.light, (LightProgress{.revision = 0, .share = 1.0}));
    EXPECT_FALSE(on.lightNow);
    EXPECT_FALSE(renderer().light(r).wanted);
}

TEST_F(LightInProgress, LightIsTheSameWhenItIsComputedAgain) {
    const auto draw = [] {
        Scene scene;
        placeRoom(scene, addMaterial(scene, lambert(0.5f, 0.25f)));
        place(scene, sphere(0.3f, 16, addMaterial(scene, lambert(0.8f))));
        return renderer().render(lit(request(std::move(scene), "again", {0.0, 0.0, 0.9}))).image;
    };
    EXPECT_TRUE(sameBytes(draw(), draw()));
}

// Materials and the environment belong to the light; the camera and the size do not.
TEST_F(LightInProgress, WhatTheLightDependsOnBeginsAnother) {
    Scene scene;
    Material walls = lambert(0.5f, 0.25f);
    walls.name = "walls";
    placeRoom(scene, addMaterial(scene, walls));
    const FrameRequest r = lit(request(std::move(scene), "other", {0.0, 0.0, 0.5}));
    const Image before = renderer().render(r).image;
    FrameRequest view = r;
    view.camera.position = glm::dvec3(0.1, 0.2, 0.4);
    view.width = 48;
    EXPECT_TRUE(renderer().light(view).complete);
    FrameRequest painted = r;
    painted.overrides.push_back({.material = "walls", .baseColor = glm::dvec3(0.5, 0.0, 0.0)});
    const glm::vec3 red = centerColor(renderer().render(lit(painted)).image);
    EXPECT_NEAR(red.x, 0.5f, 0.025f);
    EXPECT_NEAR(red.y, 0.25f, 0.01f);  // what the walls emit; they send nothing back
    EXPECT_TRUE(sameBytes(renderer().render(r).image, before));
}
