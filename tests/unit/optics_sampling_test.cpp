// Sampling: point sets, directions of the lobe, frames, levels.
#include "optics_support.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

TEST(Hammersley, FirstPoints) {
    const float expected[] = {0.0f, 0.5f, 0.25f, 0.75f, 0.125f, 0.625f, 0.375f, 0.875f};
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec2 p = glsl::hammersley(i, 8);
        EXPECT_FLOAT_EQ(p.x, (float(i) + 0.5f) / 8.0f);
        EXPECT_EQ(p.y, expected[i]);
    }
    EXPECT_LT(glsl::radicalInverse(0xffffffffu), 1.0f);
    EXPECT_TRUE(std::isfinite(glsl::hammersley(0, 0).x));
}

// The moments that the density itself has, by quadrature of the textbook's formula.
TEST(GgxHalfVector, FollowsItsDensity) {
    for (const double roughness : {0.1, 0.3, 0.5, 0.8, 1.0}) {
        const double alpha = roughness * roughness;
        double mass = 0.0, first = 0.0, second = 0.0;
        const int steps = 20000;
        for (int i = 0; i < steps; ++i) {  // tan = alpha x / (1 - x) reaches every angle
            const double x = (i + 0.5) / steps;
            const double tangent = alpha * x / (1.0 - x);
            const double c2 = 1.0 / (1.0 + tangent * tangent), c = std::sqrt(c2);
            const double weight = 2.0 * kTruePi * textbookDistribution(c, alpha) * tangent * c2 *
                                  c2 * alpha / ((1.0 - x) * (1.0 - x)) / steps;
            mass += weight;
            first += weight * c;
            second += weight * c2;
        }
        ASSERT_NEAR(mass, 1.0, 1e-5);
        const unsigned n = 1u << 14;
        glm::dvec3 mean(0.0);
        double meanZ2 = 0.0;
        unsigned within = 0;
        for (unsigned i = 0; i < n; ++i) {
            const glm::vec3 h = glsl::ggxHalfVector(glsl::hammersley(i, n), float(alpha));
            ASSERT_NEAR(glm::length(h), 1.0f, 1e-6f);
            mean += glm::dvec3(h);
            meanZ2 += double(h.z) * h.z;
            // Half of all normals are within tan = alpha (Walter 2007, formula 35).
            within += std::hypot(h.x, h.y) <= alpha * h.z ? 1 : 0;
        }
        EXPECT_NEAR(mean.x / n, 0.0, 1e-4);
        EXPECT_NEAR(mean.y / n, 0.0, 1e-4);
        EXPECT_NEAR(mean.z / n, first, 1e-3) << roughness;
        EXPECT_NEAR(meanZ2 / n, second, 1e-3) << roughness;
        EXPECT_NEAR(double(within) / n, 0.5, 1e-3) << roughness;
    }
}

TEST(GgxHalfVector, IsUnitAtTheEdges) {
    for (const float alpha : {0.0f, 1e-6f, 0.002f, 1.0f}) {
        for (const float w : {0.0f, 1e-7f, 0.5f, 1.0f - 6e-8f, 1.0f}) {
            const glm::vec3 h = glsl::ggxHalfVector({0.3f, w}, alpha);
            EXPECT_TRUE(glm::length(h) < 1.00001f && h.z >= 0.0f) << alpha << ' ' << w;
        }
    }
    EXPECT_EQ(glsl::ggxHalfVector({0.7f, 0.5f}, 0.0f), glm::vec3(0.0f, 0.0f, 1.0f));
}

// At every drawn direction the lobe is its share times the density it was drawn with, by the
// textbook's formulae; and the shares' mean is what a white lobe returns, by quadrature.
TEST(GgxVisibleNormal, WeightAndDensityReproduceTheLobe) {
    for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
        for (const double nDotV : {0.02, 0.1, 0.35, 0.7, 1.0}) {
            const double alpha = roughness * roughness;
            const glm::vec3 v(std::sqrt(1.0 - nDotV * nDotV), 0.0, nDotV);
            const unsigned n = 1u << 14;
            double mean = 0.0;
            for (unsigned i = 0; i < n; ++i) {
                const glm::vec3 h = glsl::ggxVisibleNormal(glsl::hammersley(i, n), v, float(alpha));
                ASSERT_NEAR(glm::length(h), 1.0f, 1e-6f);
                // At the cap's edge a facet is the small difference of two floats.
                ASSERT_GE(glm::dot(v, h), -1e-3f) << "the eye sees no facet's back";
                const glm::vec3 l = 2.0f * glm::dot(v, h) * h - v;
                const double share = glsl::ggxShareOfVisible(l.z, v.z, float(alpha));
                mean += share / n;
                if (l.z < 1e-3f) continue;
                const double pdf =
                    glsl::ggxVisibleDensity(h.z, h.x * h.x + h.y * h.y, v.z, float(alpha));
                const double lobe = textbookDistribution(h.z, alpha) *
                                    textbookMaskingShadowing(l.z, nDotV, alpha) / (4.0 * nDotV);
                ASSERT_NEAR(share * pdf / lobe, 1.0, 2e-3) << roughness << ' ' << nDotV;
            }
            double returned = 0.0;
            const int rings = 2000, turns = 256;
            for (int i = 0; i < rings; ++i) {
                const double x = (i + 0.5) / rings, tangent = alpha * x / (1.0 - x);
                const double c = 1.0 / std::sqrt(1.0 + tangent * tangent), s = tangent * c;
                const double solid =
                    alpha * s * c * c / ((1.0 - x) * (1.0 - x)) / rings * (2.0 * kTruePi / turns);
                for (int k = 0; k < turns; ++k) {
                    const double turn = 2.0 * kTruePi * (k + 0.5) / turns;
                    const double vh = s * std::cos(turn) * double(v.x) + c * nDotV;
                    const double lz = 2.0 * vh * c - nDotV;
                    if (vh <= 0.0 || lz <= 0.0) continue;
                    returned += textbookDistribution(c, alpha) *
                                textbookMaskingShadowing(lz, nDotV, alpha) * vh / nDotV * solid;
                }
            }
            EXPECT_NEAR(mean, returned, 3e-3) << roughness << ' ' << nDotV;
        }
    }
}

TEST(GgxVisibleNormal, IsUnitAtTheEdges) {
    for (const float alpha : {0.0f, 1e-6f, 0.04f, 1.0f}) {
        for (const glm::vec3& v :
             {glm::vec3(0, 0, 1), glm::vec3(1, 0, 0), glm::vec3(1, 0, -1e-7f)}) {
            for (const float w : {0.0f, 0.5f, 1.0f - 6e-8f}) {
                const glm::vec3 h = glsl::ggxVisibleNormal({0.3f, w}, v, alpha);
                EXPECT_TRUE(std::abs(glm::length(h) - 1.0f) < 1e-5f && h.z > 0.0f)
                    << alpha << ' ' << w;
            }
        }
    }
    for (const float c : hardCosines()) {
        EXPECT_TRUE(std::isfinite(glsl::ggxShareOfVisible(c, c, 0.0f)));
        EXPECT_TRUE(std::isfinite(glsl::ggxVisibleDensity(c, 0.0f, c, 0.04f)));
    }
}

TEST(SampleRoughness, MatchesTheWidthOfPrefilteredMaps) {
    for (const float pdf : {0.1f, 1.0f, 30.0f, 1000.0f}) {
        const float roughness = glsl::sampleRoughness(pdf, 16.0f);
        EXPECT_NEAR(glsl::environmentLod(roughness, 4096.0f, 99.0f),
                    glsl::sampleLod(pdf, 16.0f, 4096.0f), 1e-4f);
    }
    EXPECT_EQ(glsl::sampleRoughness(0.0f, 0.0f), 1.0f);
}

TEST(FrameAbout, IsRightHandedEverywhere) {
    std::vector<glm::vec3> normals{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
    for (const float tilt : {1e-8f, 1e-4f, 1e-3f}) {
        normals.push_back(glm::normalize(glm::vec3(tilt, -tilt, -1.0f)));
        normals.push_back(glm::normalize(glm::vec3(1.0f, 0.5f, -tilt)));
    }
    for (unsigned i = 0; i < 200; ++i) {
        const glm::vec2 p = glsl::hammersley(i, 200);
        const float z = 2.0f * p.x - 1.0f, r = std::sqrt(1.0f - z * z), turn = 6.2831853f * p.y;
        normals.push_back(glm::normalize(glm::vec3(r * std::cos(turn), r * std::sin(turn), z)));
    }
    for (const glm::vec3& n : normals) {
        const glm::mat3 frame = glsl::frameAbout(n);
        EXPECT_EQ(frame[2], n);
        EXPECT_NEAR(glm::determinant(frame), 1.0f, 2e-6f);
        const glm::mat3 product = glm::transpose(frame) * frame;
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) EXPECT_NEAR(product[i][k], i == k ? 1.0f : 0.0f, 2e-6f);
        }
    }
}

TEST(EnvironmentLod, FollowsTheWidthOfTheLobe) {
    EXPECT_EQ(glsl::environmentLod(0.0f, 256.0f, 9.0f), 0.0f);
    EXPECT_NEAR(glsl::environmentLod(0.5f, 256.0f, 9.0f), std::log2(std::sqrt(6.0) * 64.0), 1e-5);
    EXPECT_EQ(glsl::environmentLod(1.0f, 256.0f, 5.0f), 4.0f);
    EXPECT_EQ(glsl::environmentLod(1.0f, 0.0f, 0.0f), 0.0f);
    float before = 0.0f;
    for (int i = 0; i <= 100; ++i) {
        const float lod = glsl::environmentLod(float(i) / 100.0f, 256.0f, 9.0f);
        EXPECT_GE(lod, before);
        before = lod;
    }
    for (const float roughness : {0.2f, 0.4f, 0.6f}) {  // twice as many texels, one level more
        EXPECT_NEAR(glsl::environmentLod(roughness, 512.0f, 20.0f) -
                        glsl::environmentLod(roughness, 256.0f, 20.0f),
                    1.0f, 1e-5f);
    }
}

TEST(SampleLod, TexelsCoverTheSolidAngleOfASample) {
    // One uniform sample covers the sphere: 6 faces of 64 x 64, a level quarters their number;
    // 6 texels are left at level 6, one more for the share of 6.
    EXPECT_NEAR(glsl::sampleLod(float(1.0 / (4.0 * kTruePi)), 1.0f, 64.0f),
                6.0 + 0.5 * std::log2(6.0), 1e-4);
    EXPECT_EQ(glsl::sampleLod(1e6f, 64.0f, 64.0f), 0.0f);
    EXPECT_TRUE(std::isfinite(glsl::sampleLod(0.0f, 64.0f, 64.0f)));
}

}  // namespace
}  // namespace clerestory::test
