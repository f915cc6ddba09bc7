#include "light/sky.h"

#include "light/directions.h"

#include <gtest/gtest.h>

#include <numbers>

namespace clerestory::light {
namespace {

// Dim but for a window of 8 degrees.
EnvironmentMap windowMap() {
    EnvironmentMap map{.name = "window"};
    map.faceSize = 64;
    const glm::vec3 towards = glm::normalize(glm::vec3(0.3f, 0.8f, -0.5f));
    for (std::uint32_t i = 0; i < 6 * 64 * 64; ++i) {
        const glm::vec3 along =
            glm::normalize(cubeTexelDirection(i / 4096, i % 64, i / 64 % 64, 64));
        map.texels.push_back(glm::vec3(glm::dot(along, towards) > 0.99f ? 200.0f : 0.1f));
    }
    return map;
}

glm::vec3 uniformDirection(std::uint32_t i) {
    const glm::vec2 u = pointOfSequence(i, 1);
    const float z = 2.0f * u.x - 1.0f, radius = std::sqrt(1.0f - z * z);
    const float turn = 2.0f * std::numbers::pi_v<float> * u.y;
    return {radius * std::cos(turn), radius * std::sin(turn), z};
}

}  // namespace

TEST(Sky, DensitiesIntegrateToOne) {
    const Sky sky(windowMap());
    constexpr std::uint32_t kCount = 400'000;
    double sum = 0.0;
    for (std::uint32_t i = 0; i < kCount; ++i) sum += double{sky.density(uniformDirection(i))};
    EXPECT_NEAR(sum * 4.0 * std::numbers::pi / kCount, 1.0, 0.01);
}

// Few samples estimate the light of all directions, whatever its shape.
TEST(Sky, SamplesHaveTheDensityOfTheLight) {
    const Sky sky(windowMap());
    constexpr std::uint32_t kMany = 400'000, kFew = 128;
    double truth = 0.0, estimate = 0.0;
    for (std::uint32_t i = 0; i < kMany; ++i) truth += double{sky.radiance(uniformDirection(i)).x};
    truth *= 4.0 * std::numbers::pi / kMany;
    for (std::uint32_t i = 0; i < kFew; ++i) {
        const glm::vec3 along =
            sky.sample((static_cast<float>(i) + 0.5f) / kFew, pointOfSequence(i, 2));
        EXPECT_NEAR(glm::length(along), 1.0f, 1e-5f);
        estimate += double{sky.radiance(along).x} / double{sky.density(along)};
    }
    EXPECT_NEAR(estimate / kFew / truth, 1.0, 0.05);
}

TEST(Sky, OnlyWindowsAndLampsMakeItUneven) {
    EXPECT_TRUE(Sky(windowMap()).uneven());
    EXPECT_TRUE(Sky(*builtinEnvironment("studio")).uneven());
    for (const char* name : {"sky", "dusk", "white", "black"}) {
        EXPECT_FALSE(Sky(*builtinEnvironment(name)).uneven()) << name;
    }
}

}  // namespace clerestory::light
