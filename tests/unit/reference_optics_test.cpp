// The reference's Fresnel equations, refraction and panes compared with textbook values.
#include "reference/bsdf.h"
#include "reference/scene_geometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clerestory::reference {
namespace {

double cosineOf(double degrees) {
    return std::cos(degrees * kPi / 180.0);
}

TEST(ReferenceFresnel, SpotValues) {
    EXPECT_NEAR(fresnel(1.0, 1.5).mean(), 0.04, 1e-12);
    EXPECT_NEAR(fresnel(1.0, 1.0 / 1.5).mean(), 0.04, 1e-12);
    // Errata G4: the amplitudes at 45 degrees.
    EXPECT_NEAR(fresnel(cosineOf(45), 1.5).mean(),
                0.5 * (0.0920134 * 0.0920134 + 0.3033370 * 0.3033370), 1e-6);
    EXPECT_NEAR(fresnel(std::cos(std::atan(1.5)), 1.5).p, 0.0, 1e-15);  // Brewster
    EXPECT_GT(fresnel(std::cos(std::atan(1.5)), 1.5).s, 0.14);
    EXPECT_DOUBLE_EQ(fresnel(0.0, 1.5).mean(), 1.0);
    EXPECT_DOUBLE_EQ(fresnel(0.5, 1.0).mean(), 0.0);
    EXPECT_DOUBLE_EQ(fresnel(0.0, 1.0).mean(), 0.0);
}

TEST(ReferenceFresnel, ReflectsTotallyBeyondTheCriticalAngle) {
    const double critical = std::asin(1.0 / 1.5) * 180.0 / kPi;  // 41.81 degrees
    EXPECT_LT(fresnel(cosineOf(critical - 0.01), 1.0 / 1.5).mean(), 1.0);
    EXPECT_DOUBLE_EQ(fresnel(cosineOf(critical + 0.01), 1.0 / 1.5).mean(), 1.0);
    EXPECT_LT(refractedCosine(cosineOf(critical + 0.01), 1.0 / 1.5), 0.0);
}

TEST(ReferenceFresnel, IsTheSameFromBothSides) {
    for (double degrees = 0.0; degrees < 90.0; degrees += 0.5) {
        const double out = cosineOf(degrees), in = refractedCosine(out, 1.5);
        EXPECT_NEAR(fresnel(out, 1.5).s, fresnel(in, 1.0 / 1.5).s, 1e-9) << degrees;
        EXPECT_NEAR(fresnel(out, 1.5).p, fresnel(in, 1.0 / 1.5).p, 1e-9) << degrees;
    }
}

TEST(ReferenceFresnel, RefractsAsSnellSays) {
    const glm::dvec3 n(0, 0, 1);
    for (const double eta : {1.0, 1.1, 1.5, 2.4, 1.0 / 1.3}) {
        for (double degrees = 0.0; degrees < 89.9; degrees += 0.7) {
            const double c = cosineOf(degrees), s = std::sqrt(1.0 - c * c);
            if (refractedCosine(c, eta) < 0.0) continue;
            const glm::dvec3 bent = refracted({s, 0.0, -c}, n, eta);
            EXPECT_NEAR(glm::length(bent), 1.0, 1e-12);
            EXPECT_NEAR(bent.x * eta, s, 1e-9) << eta << " " << degrees;
            EXPECT_LE(bent.z, 0.0);
        }
    }
}

// The series itself: in, k ways across, out at either face.
PaneCoefficients bouncedPane(double cosine, double ior, double clear) {
    const PolarisedReflectance f = fresnel(cosine, ior);
    PaneCoefficients sum;
    for (const double r : {f.s, f.p}) {
        double back = r, through = 0.0, within = 1.0 - r;
        for (int ways = 1; ways < 4000; ++ways) {
            within *= clear;
            (ways % 2 == 1 ? through : back) += within * (1.0 - r);
            within *= r;
        }
        sum.reflected += 0.5 * back;
        sum.transmitted += 0.5 * through;
    }
    return sum;
}

TEST(ReferencePane, IsTheSumOfItsReflections) {
    for (const double clear : {1.0, 0.9, 0.3, 0.0}) {
        for (const double degrees : {0.0, 30.0, 60.0, 80.0, 89.0}) {
            const double c = cosineOf(degrees);
            const PaneCoefficients shares = paneCoefficients(c, 1.5, glm::dvec3(clear));
            const PaneCoefficients expected = bouncedPane(c, 1.5, clear);
            EXPECT_NEAR(shares.reflected.x, expected.reflected.x, 1e-9) << degrees << " " << clear;
            EXPECT_NEAR(shares.transmitted.y, expected.transmitted.y, 1e-9) << degrees;
        }
    }
}

TEST(ReferencePane, MatchesTheErrataTable) {  // G3
    const std::pair<double, double> table[] = {
        {0.0, 0.923}, {45.0, 0.907}, {60.0, 0.848}, {80.0, 0.459}, {89.0, 0.051}};
    for (const auto& [degrees, transmitted] : table) {
        const PaneCoefficients shares = paneCoefficients(cosineOf(degrees), 1.5, glm::dvec3(1.0));
        EXPECT_NEAR(shares.transmitted.x, transmitted, 6e-4) << degrees;
        EXPECT_NEAR(shares.transmitted.x + shares.reflected.x, 1.0, 1e-12);
    }
}

TEST(ReferenceAbsorption, FollowsBeerAndLambert) {
    const glm::dvec3 left = beerLambert({0.5, 1.0, 0.0}, 2.0, 4.0);
    EXPECT_DOUBLE_EQ(left.x, 0.25);
    EXPECT_DOUBLE_EQ(left.y, 1.0);
    EXPECT_DOUBLE_EQ(left.z, 0.0);
    EXPECT_EQ(beerLambert({0.5, 0.5, 0.5}, 0.0, 4.0), glm::dvec3(1.0));
}

}  // namespace
}  // namespace clerestory::reference
