// The GGX lobe compared with the textbook in double.
#include "optics_support.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace clerestory::test {
namespace {

TEST(Ggx, DensityIsNormalised) {
    for (float roughness = 0.05f; roughness <= 1.0f; roughness += 0.05f) {
        const float alpha = roughness * roughness;
        double sum = 0.0;
        const int steps = 4000;
        for (int i = 0; i < steps; ++i) {  // tan = alpha x / (1 - x) reaches every angle
            const double x = (i + 0.5) / steps;
            const double tangent = double(alpha) * x / (1.0 - x);
            const double c2 = 1.0 / (1.0 + tangent * tangent);
            const double d = glsl::ggxDistribution(float(std::sqrt(c2)), float(1.0 - c2), alpha);
            sum += 2.0 * kTruePi * d * tangent * c2 * c2 * double(alpha) / ((1.0 - x) * (1.0 - x)) /
                   steps;
        }
        EXPECT_NEAR(sum, 1.0, 1e-4) << roughness;
    }
}

TEST(Ggx, DensityMatchesTheTextbook) {
    for (const float roughness : {0.045f, 0.1f, 0.3f, 0.6f, 1.0f}) {
        const double alpha = double(roughness) * roughness;
        for (double tangent = 0.0; tangent < 5.0 * alpha; tangent += 0.1 * alpha) {
            const double c2 = 1.0 / (1.0 + tangent * tangent), c = std::sqrt(c2);
            const double expected = textbookDistribution(c, alpha);
            EXPECT_NEAR(
                glsl::ggxDistribution(float(c), float(1.0 - c2), roughness * roughness) / expected,
                1.0, 1e-3)
                << roughness << " at tan " << tangent;
        }
    }
}

// Sums of the textbook's density over the disc, point by point.
double summedMean(double tangent, double alpha, double radius) {
    constexpr int kRings = 400, kTurns = 128;
    double sum = 0.0;
    for (int i = 0; i < kRings; ++i) {
        // Rings of equal area.
        const double r = radius * std::sqrt((i + 0.5) / kRings);
        for (int k = 0; k < kTurns; ++k) {
            const double turn = 2.0 * kTruePi * (k + 0.5) / kTurns;
            const double x = tangent + r * std::cos(turn), y = r * std::sin(turn);
            const double a = alpha * alpha + x * x + y * y;
            sum += alpha * alpha / (kTruePi * a * a);  // of slopes
        }
    }
    return sum / (double(kRings) * kTurns);
}

TEST(Ggx, MeanOverADiscMatchesNumericalIntegration) {
    for (const double alpha : {0.002025, 0.02, 0.3}) {
        for (const double radius : {0.003, 0.05, 0.4}) {
            for (const double tangent : {0.0, 0.3, 0.9, 1.2, 3.0}) {
                const double t = tangent * radius;
                if (radius > 4.0 * alpha && tangent < 1.0) continue;  // too sharp to be summed
                const double c2 = 1.0 / (1.0 + t * t);
                const double mean = glsl::ggxMeanDistribution(
                    float(c2), float(1.0 - c2), float(alpha * alpha), float(radius * radius));
                EXPECT_NEAR(mean * c2 * c2 / summedMean(t, alpha, radius), 1.0, 5e-3)
                    << alpha << ' ' << radius << ' ' << tangent;
            }
        }
    }
}

// However narrow the lobe: what a disc about it holds is the lobe's share within it.
TEST(Ggx, MeanOverAWideDiscContainsTheWholeLobe) {
    for (const double alpha : {0.002025, 0.02}) {
        const double radius2 = 0.16;
        const double mean = glsl::ggxMeanDistribution(1.0f, 0.0f, float(alpha * alpha), 0.16f);
        EXPECT_NEAR(mean * kTruePi * radius2, radius2 / (radius2 + alpha * alpha), 1e-4);
    }
}

TEST(Ggx, MeanOverAnEmptyDiscIsTheDensity) {
    for (const float roughness : {0.045f, 0.3f, 1.0f}) {
        const float alpha = roughness * roughness;
        for (double t = 0.0; t < 20.0 * alpha; t += 0.7 * alpha) {
            const double c2 = 1.0 / (1.0 + t * t);
            const double exact = textbookDistribution(std::sqrt(c2), alpha);
            for (const float covered : {0.0f, 1e-30f, 1e-9f * alpha * alpha}) {
                EXPECT_NEAR(
                    glsl::ggxMeanDistribution(float(c2), float(1.0 - c2), alpha * alpha, covered) /
                        exact,
                    1.0, 1e-4)
                    << roughness << ' ' << t << ' ' << covered;
            }
        }
    }
}

TEST(Ggx, MeanIsFiniteAndPositiveForInvalidInput) {
    for (const float alpha : {0.002025f, 0.25f, 1.0f}) {
        for (const float covered : {0.0f, 1e-38f, 1e-12f, 1e-3f, 0.18f}) {
            for (const float c2 : {0.0f, 1e-30f, 0.5f, 1.0f, 1.0001f}) {
                for (const float s2 : {0.0f, 1e-30f, 0.5f, 1.0f, 1e6f}) {
                    const float mean = glsl::ggxMeanDistribution(c2, s2, alpha * alpha, covered);
                    EXPECT_TRUE(std::isfinite(mean) && mean >= 0.0f)
                        << alpha << ' ' << covered << ' ' << c2 << ' ' << s2 << ": " << mean;
                }
            }
        }
    }
}

TEST(Ggx, VisibilityMatchesTheTextbook) {
    for (const float roughness : {0.045f, 0.1f, 0.3f, 0.6f, 1.0f}) {
        const float alpha = roughness * roughness;
        for (const float l : {0.001f, 0.01f, 0.1f, 0.5f, 0.9f, 1.0f}) {
            for (const float v : {0.001f, 0.01f, 0.1f, 0.5f, 0.9f, 1.0f}) {
                const double expected =
                    textbookMaskingShadowing(l, v, alpha) / (4.0 * double(l) * v);
                EXPECT_NEAR(glsl::ggxVisibility(l, v, alpha) / expected, 1.0, 1e-5)
                    << roughness << ' ' << l << ' ' << v;
            }
        }
    }
}

TEST(Ggx, IsFiniteAndPositiveForInvalidCosines) {
    for (const float alpha : {0.0f, 1e-20f, 1e-6f, 0.002f, 0.25f, 1.0f}) {
        for (const float a : hardCosines()) {
            for (const float b : hardCosines()) {
                const float visibility = glsl::ggxVisibility(a, b, alpha);
                EXPECT_TRUE(visibility > 0.0f && visibility < 1e8f) << a << ' ' << b;
                const float d = glsl::ggxDistribution(a, std::max(b, 0.0f), alpha);
                EXPECT_TRUE(d >= 0.0f && d < 1e10f) << a << ' ' << b << ": " << d;
                const glm::vec2 at = glsl::environmentBrdfCoordinate(a, b, 64.0f);
                EXPECT_TRUE(at.x > 0.0f && at.x < 1.0f && at.y > 0.0f && at.y < 1.0f);
            }
        }
    }
    EXPECT_TRUE(std::isfinite(glsl::ggxVisibility(0.0f, 0.0f, 0.0f)));
}

TEST(Diffuse, KeepsItsHueUnderAColouredSpecularLobe) {
    EXPECT_FLOAT_EQ(glsl::diffuseWeight({0.1f, 0.3f, 0.2f}), 0.7f);
    EXPECT_EQ(glsl::diffuseWeight(glm::vec3(2.0f)), 0.0f);
}

}  // namespace
}  // namespace clerestory::test
