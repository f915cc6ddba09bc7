// Compares the planner's predicted errors of each technique with measured ones.
#include "predictions.h"
#include "scene/default_view.h"
#include "scenes.h"

#include <gtest/gtest.h>

namespace clerestory::bench {
namespace {

class Predictions : public testing::TestWithParam<const char*> {};

TEST_P(Predictions, RankTechniquesAsMeasured) {
    const Scene scene = loadScene(GetParam());
    Renderer renderer{RendererOptions{}};
    renderer.addScene(scene);
    FrameRequest frame = turned(scene.id, defaultView(scene), 0.0);
    frame.width = 160;
    frame.height = 90;
    frame.accuracy.samples = 4;
    frame.accuracy.edgeFilter = false;
    EnvironmentMaps maps;
    maps[scene.environment] =
        std::make_shared<const EnvironmentMap>(*builtinEnvironment(scene.environment));
    // If a mirror shows a lamp in a hundredth of a pixel, 64 paths find a third of it or nothing,
    // and one such pixel then outweighs the picture.
    const auto truth = traceReference({.scene = scene,
                                       .frame = frame,
                                       .environment = *maps[scene.environment],
                                       .maps = maps,
                                       .samples = 1024});
    const auto predictions = measurePredictions(frame, *truth, [&](const FrameRequest& request) {
        Frame drawn = renderer.render(request);
        return DrawnFrame{std::move(drawn.image), 0.0, std::move(drawn.plan)};
    });
    const Agreement agreement = agreementOf(predictions);
    EXPECT_GT(agreement.pairs, 0);
    for (const std::string& line : agreement.reversed) ADD_FAILURE() << line;
    if (HasFailure()) std::printf("%s", textOf(predictions).c_str());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Predictions,
                         testing::Values("chapel", "teapots", "six-walls", "orbiting-cubes"),
                         [](const auto& scene) {
                             std::string name = scene.param;
                             std::erase(name, '-');
                             return name;
                         });

TEST(Agreement, CountsInvertedPairs) {
    const Effect flat = Effect::planarReflection, curved = Effect::environmentReflection;
    std::vector<Prediction> p = {{flat, Method::environment, 1.2, 2.0, 0.01},
                                 {flat, Method::mirror, 0.02, 0.1, 0.01},
                                 {curved, Method::probe, 0.5, 5.0, 0.01},
                                 {flat, Method::traced, 0.0201, 0.3, 0.01}};
    EXPECT_EQ(agreementOf(p).pairs, 2) << "two are too near, and effects are not mixed";
    EXPECT_TRUE(agreementOf(p).reversed.empty());
    p[1].measured = 2.11;  // within 1.05 times and the noise
    EXPECT_TRUE(agreementOf(p).reversed.empty());
    p[1].measured = 2.13;
    EXPECT_EQ(agreementOf(p).reversed.size(), 1u);
    EXPECT_NE(textOf(p).find("1 are the other way round"), std::string::npos);
}

}  // namespace
}  // namespace clerestory::bench
