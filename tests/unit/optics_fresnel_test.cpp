// Fresnel equations: the two polarisations, known values, limits, and the error of Schlick's
// approximation.
#include "optics_support.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

struct Polarised {
    double s, p;
    double mean() const { return 0.5 * (s + p); }
};

// Fresnel's equations with Snell's angle (Born and Wolf): another road than the code takes.
Polarised bySnell(double cosine, double eta) {
    const double sine2 = (1.0 - cosine * cosine) / (eta * eta);
    if (sine2 >= 1.0) return {1.0, 1.0};
    const double inner = std::sqrt(1.0 - sine2);
    const double s = (cosine - eta * inner) / (cosine + eta * inner);
    const double p = (eta * cosine - inner) / (eta * cosine + inner);
    return {s * s, p * p};
}

float atDegrees(double degrees, float eta) {
    return glsl::fresnelDielectric(float(std::cos(radians(degrees))), eta);
}

TEST(Fresnel, KnownValuesOfGlass) {
    EXPECT_NEAR(atDegrees(0, 1.5f), 0.04f, 1e-6f);
    EXPECT_NEAR(atDegrees(45, 1.5f), 0.5 * (0.0920134 * 0.0920134 + 0.3033370 * 0.3033370), 1e-6);
    EXPECT_NEAR(atDegrees(45, 1.5f), 0.050240, 1e-6);
    EXPECT_EQ(glsl::fresnelDielectric(0.0f, 1.5f), 1.0f);
    EXPECT_EQ(glsl::fresnelDielectric(0.0f, 1.0f / 1.5f), 1.0f);
}

// At Brewster's angle, tan = eta, nothing of p is reflected: half of s is all there is, and s is
// ((eta^2 - 1) / (eta^2 + 1))^2.
TEST(Fresnel, OnlyOnePolarisationAtBrewstersAngle) {
    for (const double eta : {1.1, 1.33, 1.5, 2.42, 1.0 / 1.5}) {
        const double s = std::pow((eta * eta - 1.0) / (eta * eta + 1.0), 2.0);
        const double cosine = 1.0 / std::sqrt(1.0 + eta * eta);
        EXPECT_NEAR(bySnell(cosine, eta).p, 0.0, 1e-12);
        EXPECT_NEAR(glsl::fresnelDielectric(float(cosine), float(eta)), 0.5 * s, 2e-6) << eta;
    }
    EXPECT_NEAR(atDegrees(56.3099, 1.5f), 0.0739645, 1e-6);  // (5/13)^2 / 2
}

TEST(Fresnel, EqualsSnellFromBothSides) {
    for (const float eta : {1.0003f, 1.1f, 1.33f, 1.5f, 1.8f, 2.42f, 3.0f}) {
        for (double degrees = 0.0; degrees < 90.0; degrees += 0.25) {
            const float cosine = float(std::cos(radians(degrees)));
            // Near grazing and the critical angle the curve is steep: an error of the argument's
            // last bit counts there, so the reference takes the same float argument.
            EXPECT_NEAR(glsl::fresnelDielectric(cosine, eta), bySnell(cosine, eta).mean(), 3e-6)
                << eta << " at " << degrees;
        }
    }
    const float out = 1.0f / 1.5f;
    for (double degrees = 0.0; degrees < 41.5; degrees += 0.25) {
        const float cosine = float(std::cos(radians(degrees)));
        EXPECT_NEAR(glsl::fresnelDielectric(cosine, out), bySnell(cosine, out).mean(), 2e-5)
            << degrees;
    }
}

TEST(Fresnel, TotalReflectionInsideBeyondTheCriticalAngle) {
    // asin(1 / 1.5) = 41.8103 degrees.
    for (double degrees = 41.82; degrees <= 90.0; degrees += 0.1) {
        EXPECT_EQ(atDegrees(degrees, 1.0f / 1.5f), 1.0f) << degrees;
    }
    EXPECT_LT(atDegrees(41.80, 1.0f / 1.5f), 0.97f);
    EXPECT_NEAR(atDegrees(0.0, 1.0f / 1.5f), 0.04f, 1e-6f);
}

// Light takes the same way back: outside at an angle, inside at its refracted angle.
TEST(Fresnel, SameInBothDirections) {
    for (double degrees = 0.0; degrees < 89.0; degrees += 1.0) {
        const double inner = std::asin(std::sin(radians(degrees)) / 1.5);
        EXPECT_NEAR(atDegrees(degrees, 1.5f),
                    glsl::fresnelDielectric(float(std::cos(inner)), 1.0f / 1.5f), 2e-4)
            << degrees;
    }
}

TEST(Fresnel, AnIndexOfOneVanishesAlsoAtGrazing) {
    for (const float cosine : hardCosines()) {
        EXPECT_EQ(glsl::fresnelDielectric(cosine, 1.0f), 0.0f) << cosine;
    }
    for (const float eta : {0.9999f, 0.99999f, 1.00001f, 1.0001f, 1.0003f}) {
        for (double degrees = 0.0; degrees <= 80.0; degrees += 5.0) {
            EXPECT_LT(atDegrees(degrees, eta), 1e-4f) << eta << " at " << degrees;
        }
    }
}

TEST(Fresnel, IncreasesContinuouslyTowardsGrazing) {
    for (const float eta : {1.0003f, 1.1f, 1.5f, 3.0f}) {
        float before = atDegrees(80.0, eta);
        double slope = 0.0;
        for (int i = 1; i <= 999; ++i) {
            const double degrees = 80.0 + 0.01 * i;
            const float now = atDegrees(degrees, eta);
            EXPECT_GE(now, before - 1e-6f) << eta << " at " << degrees;
            const double expected = bySnell(std::cos(radians(degrees)), eta).mean() -
                                    bySnell(std::cos(radians(degrees - 0.01)), eta).mean();
            slope = std::max(slope, std::abs(double(now - before) - expected));
            before = now;
        }
        EXPECT_LT(slope, 2e-5) << eta;  // a step that the true curve does not have
    }
}

TEST(Fresnel, StaysWithinZeroAndOne) {
    for (const float cosine : hardCosines()) {
        for (const float eta :
             {-1.0f, 0.0f, 1e-30f, 0.3f, 0.999999f, 1.0f, 1.000001f, 1.5f, 1e6f, kInf}) {
            const float f = glsl::fresnelDielectric(cosine, eta);
            EXPECT_TRUE(f >= 0.0f && f <= 1.0f) << cosine << ' ' << eta << ": " << f;
        }
        const float s = glsl::fresnelSchlick(glm::vec3(0.04f), glm::vec3(1.0f), cosine).x;
        EXPECT_TRUE(s >= 0.04f && s <= 1.0f) << cosine << ": " << s;
    }
}

TEST(Fresnel, ErrorOfSchlick) {
    double worst = 0.0, worstAt = 0.0, least = 0.0, leastAt = 0.0;
    for (double degrees = 0.0; degrees < 90.0; degrees += 0.1) {
        const double cosine = std::cos(radians(degrees));
        const double exact = bySnell(cosine, 1.5).mean();
        const double off =
            glsl::fresnelSchlick(glm::vec3(0.04f), glm::vec3(1.0f), float(cosine)).x - exact;
        if (std::abs(off) > std::abs(worst)) worst = off, worstAt = degrees;
        if (off / exact < least) least = off / exact, leastAt = degrees;
    }
    EXPECT_NEAR(std::abs(worst), 0.036, 0.001);
    EXPECT_NEAR(worstAt, 85.0, 1.0);
    EXPECT_NEAR(least, -0.23, 0.01);
    EXPECT_NEAR(leastAt, 55.0, 2.5);
}

TEST(Fresnel, SchlickIsExactAtBothEnds) {
    const glm::vec3 gold(1.0f, 0.71f, 0.29f);
    EXPECT_EQ(glsl::fresnelSchlick(gold, glm::vec3(1.0f), 1.0f), gold);
    EXPECT_EQ(glsl::fresnelSchlick(gold, glm::vec3(1.0f), 0.0f), glm::vec3(1.0f));
    EXPECT_NEAR(glsl::fresnelSchlick(gold, glm::vec3(1.0f), 0.5f).z, 0.29 + 0.71 / 32.0, 1e-6);
}

TEST(IndexOfRefraction, RoundTrip) {
    EXPECT_NEAR(glsl::f0FromIor(1.5f), 0.04f, 1e-8f);
    EXPECT_NEAR(glsl::f0FromIor(2.42f), 0.17239495, 1e-7);  // (1.42 / 3.42)^2
    EXPECT_EQ(glsl::f0FromIor(1.0f), 0.0f);
    for (double ior = 1.0003; ior <= 3.0; ior *= 1.003) {
        const float x = float(ior);
        EXPECT_NEAR(glsl::iorFromF0(glsl::f0FromIor(x)) / x, 1.0f, 1e-6f) << ior;
    }
    EXPECT_NEAR(glsl::iorFromF0(0.04f), 1.5f, 1e-6f);  // not 1 / eta^2
    for (const float f0 : {-1.0f, 0.0f, 1.0f, 5.0f}) {
        EXPECT_GE(glsl::iorFromF0(f0), 1.0f);
        EXPECT_TRUE(std::isfinite(glsl::iorFromF0(f0)));
    }
}

}  // namespace
}  // namespace clerestory::test
