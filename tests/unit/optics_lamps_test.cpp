// Punctual lights, and the final check of radiance: limits and non-finite values.
#include "optics_support.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

TEST(PointLight, FallsWithTheSquareOfTheDistance) {
    EXPECT_FLOAT_EQ(glsl::punctualAttenuation(1.0f, 0.0f), 1.0f);
    EXPECT_FLOAT_EQ(glsl::punctualAttenuation(2.0f, 0.0f), 0.25f);
    EXPECT_FLOAT_EQ(glsl::punctualAttenuation(100.0f, 0.0f), 1e-4f);
}

TEST(PointLight, IsZeroBeyondItsRange) {
    // KHR_lights_punctual: max(min(1 - (d / range)^4, 1), 0) / d^2.
    EXPECT_FLOAT_EQ(glsl::punctualAttenuation(5.0f, 10.0f), (1.0f - 0.0625f) / 25.0f);
    EXPECT_EQ(glsl::punctualAttenuation(10.0f, 10.0f), 0.0f);
    EXPECT_EQ(glsl::punctualAttenuation(1e30f, 10.0f), 0.0f);
    EXPECT_NEAR(glsl::punctualAttenuation(0.1f, 10.0f), 100.0f, 1e-3f);
}

TEST(PointLight, IsFiniteAtItsPosition) {
    for (const float range : {0.0f, 1e-30f, 1.0f, 1e30f, kInf}) {
        for (const float distance : {-1.0f, 0.0f, 1e-30f, 0.005f, 1.0f, 1e18f, 3e38f, kInf}) {
            const float a = glsl::punctualAttenuation(distance, range);
            EXPECT_TRUE(a >= 0.0f && a <= 10001.0f) << distance << ' ' << range << ": " << a;
        }
    }
    // Nearer than a centimetre it grows no more.
    EXPECT_EQ(glsl::punctualAttenuation(0.0f, 0.0f), glsl::punctualAttenuation(0.01f, 0.0f));
}

TEST(SpotLight, FullInsideZeroOutside) {
    const float inner = 0.9f, outer = 0.7f;
    EXPECT_EQ(glsl::spotAttenuation(1.0f, inner, outer), 1.0f);
    EXPECT_EQ(glsl::spotAttenuation(0.9f, inner, outer), 1.0f);
    EXPECT_NEAR(glsl::spotAttenuation(0.8f, inner, outer), 0.25f, 1e-6f);
    EXPECT_EQ(glsl::spotAttenuation(0.7f, inner, outer), 0.0f);
    EXPECT_EQ(glsl::spotAttenuation(-1.0f, inner, outer), 0.0f);
    // A cone without a soft edge: half a thousandth beyond the edge it is a quarter.
    EXPECT_NEAR(glsl::spotAttenuation(0.7005f, 0.7f, 0.7f), 0.25f, 1e-3f);
    EXPECT_EQ(glsl::spotAttenuation(0.6999f, 0.7f, 0.7f), 0.0f);
}

TEST(RadianceFinite, AcceptsOnlyFiniteRadiance) {
    EXPECT_EQ(glsl::radianceFinite(kNaN), 0.0f);
    EXPECT_EQ(glsl::radianceFinite(kInf), 0.0f);
    EXPECT_EQ(glsl::radianceFinite(-kInf), 0.0f);
    EXPECT_EQ(glsl::radianceFinite(-1.0f), 0.0f);
    EXPECT_EQ(glsl::radianceFinite(0.0f), 0.0f);
    EXPECT_EQ(glsl::radianceFinite(1e-30f), 1e-30f);
    EXPECT_EQ(glsl::radianceFinite(65504.0f), 65504.0f);
    EXPECT_EQ(glsl::radianceFinite(1e30f), 65504.0f);
    EXPECT_EQ(glsl::radianceFinite(glm::vec3(kNaN, 2.0f, -3.0f)), glm::vec3(0.0f, 2.0f, 0.0f));
}

// Not pow(): that is NaN below 0, where a cosine above 1 by rounding leads (erratum N1).
TEST(Pow5, IsClampedToItsDomain) {
    EXPECT_EQ(glsl::pow5(-1e-7f), 0.0f);
    EXPECT_EQ(glsl::pow5(2.0f), 1.0f);
    EXPECT_FLOAT_EQ(glsl::pow5(0.5f), 1.0f / 32.0f);
}

}  // namespace
}  // namespace clerestory::test
