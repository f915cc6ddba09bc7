// Which surfaces the pass of small emitters shows.
#include "plan/graph/emitter_coverage.h"

#include "view_planner_support.h"

#include <gmock/gmock.h>

namespace clerestory::test {
namespace {

Material glowing() {
    return {.name = "glowing", .emissive = glm::vec3(2.0f), .emissiveStrength = 3.0f};
}

Scene ballOf(Material material) {
    Scene scene;
    place(scene, addBallMesh(scene, "ball", addMaterial(scene, std::move(material))), {0, 0, 0},
          0.1);
    updateContentHash(scene);
    return scene;
}

std::vector<Pass> coverageOf(const Scene& scene, const FrameRequest& request) {
    return passesOf(planOf(scene, request), "emitterCoverage");
}

TEST(EmitterCoveragePlan, GlowingSurfacesArePartOfIt) {
    const FrameRequest request = lookingFrom({0, 0, 5});
    const std::vector<Pass> passes = coverageOf(ballOf(glowing()), request);
    ASSERT_EQ(passes.size(), 1u);
    const auto& work = std::get<EmitterCoverage>(passes.front().work);
    ASSERT_FALSE(work.emitters.empty());
    std::uint32_t indices = 0;
    for (const EmitterCoverage::Emitter& emitter : work.emitters) {
        indices += emitter.indexCount;
        EXPECT_EQ(emitter.radiance, glm::vec3(6.0f));
    }
    EXPECT_EQ(indices, ballOf(glowing()).indices.size());
}

TEST(EmitterCoveragePlan, ScenesWithoutThemHaveNoPass) {
    const FrameRequest request = lookingFrom({0, 0, 5});
    EXPECT_TRUE(coverageOf(ballOf(dullGrey()), request).empty());
    Material blended = glowing();
    blended.alphaMode = AlphaMode::blend;
    EXPECT_TRUE(coverageOf(ballOf(blended), request).empty());
    EXPECT_TRUE(coverageOf(ballOf(glowing()), lookingFrom({0, 0, -5}, {0, 0, -9})).empty());
}

TEST(EmitterCoveragePlan, TheSwitchesRemoveIt) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.accuracy.emitterCoverage = false;
    EXPECT_TRUE(coverageOf(ballOf(glowing()), request).empty());
    request.accuracy.emitterCoverage = true;
    request.effects.emission = false;
    EXPECT_TRUE(coverageOf(ballOf(glowing()), request).empty());
}

}  // namespace
}  // namespace clerestory::test
