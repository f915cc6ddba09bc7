// Glass: Snell's law in double, both sides of an interface, panes and balls compared with geometry
// and the two polarisations, the furnace, absorption, and the lobe width of rough glass compared
// with sampling.
#include "optics_support.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <random>

namespace clerestory::test {
namespace {

using glm::dvec3;
using glm::vec3;

const std::vector<double> kIndices{1.0003, 1.1, 1.33, 1.5, 1.8, 2.42, 3.0};

// A ray that meets the plane y = 0 from above.
dvec3 downwards(double degrees) {
    return {std::sin(radians(degrees)), -std::cos(radians(degrees)), 0.0};
}
const vec3 kUp(0.0f, 1.0f, 0.0f);

double sineTo(const vec3& direction) {
    const dvec3 d(direction);
    return std::hypot(d.x, d.z) / glm::length(d);
}
double angleBetween(const dvec3& a, const dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// ---- one interface (G5) ------------------------------------------------------------------------

TEST(Interface, SpecularFactorScalesReflection) {
    for (const float cosine : {0.0f, 0.01f, 0.5f, 1.0f}) {
        EXPECT_EQ(glsl::fresnelOfBody(cosine, 1.5f, 0.0f), 0.0f) << cosine;
        EXPECT_EQ(glsl::fresnelOfBody(cosine, 1.5f, 1.0f), glsl::fresnelDielectric(cosine, 1.5f));
        EXPECT_EQ(glsl::fresnelOfBody(cosine, 1.0f, 1.0f), 0.0f);
    }
    // Beyond the critical angle, 41.8 degrees, light has nowhere else to go.
    EXPECT_EQ(glsl::fresnelOfBody(0.7f, 1.0f / 1.5f, 0.0f), 1.0f);
    EXPECT_EQ(glsl::fresnelOfBody(0.8f, 1.0f / 1.5f, 0.0f), 0.0f);
}

TEST(Interface, SnellsLawOverASweep) {
    for (const double ior : kIndices) {
        for (double degrees = 0.0; degrees < 90.0; degrees += 0.125) {
            const vec3 in(downwards(degrees));
            const glsl::Refraction into = glsl::refractedAtSurface(in, kUp, float(ior));
            ASSERT_FALSE(into.total);
            EXPECT_NEAR(ior * sineTo(into.direction), std::sin(radians(degrees)), 1e-5)
                << ior << " at " << degrees;
            EXPECT_LT(into.direction.y, 0.0f) << "the ray goes on";
            EXPECT_GE(into.direction.x, 0.0f) << "on the same side of the normal";
            EXPECT_NEAR(glm::length(into.direction), 1.0f, 1e-6f);
            EXPECT_NEAR(into.cosine, -into.direction.y, 1e-6f);

            const glsl::Refraction out = glsl::refractedAtSurface(-in, kUp, float(ior));
            const bool total = ior * std::sin(radians(degrees)) > 1.0;
            if (std::abs(ior * std::sin(radians(degrees)) - 1.0) < 1e-6) continue;
            EXPECT_EQ(out.total, total) << ior << " at " << degrees;
            EXPECT_NEAR(sineTo(out.direction), (total ? 1.0 : ior) * std::sin(radians(degrees)),
                        1e-5)
                << ior << " at " << degrees;
            EXPECT_EQ(out.direction.y > 0.0f, !total) << ior << " at " << degrees;
        }
    }
}

TEST(Interface, RandomRaysStayInPlaneAndAreReversible) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 20000; ++i) {
        const vec3 n = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        const vec3 in = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        const float ior = 1.0f + 2.0f * float(i % 100) / 100.0f;
        const glsl::Refraction bent = glsl::refractedAtSurface(in, n, ior);
        EXPECT_NEAR(glm::dot(bent.direction, glm::cross(in, n)), 0.0f, 1e-6f);
        if (bent.total) continue;
        // An error of the last bits turns a ray by its share of the smaller cosine.
        const float least = std::min(std::abs(glm::dot(in, n)), bent.cosine);
        if (least < 0.01f) continue;
        const glsl::Refraction back = glsl::refractedAtSurface(-bent.direction, n, ior);
        EXPECT_NEAR(angleBetween(dvec3(back.direction), dvec3(-in)), 0.0, 2e-6 / least);
    }
}

// Flipping the winding of a two-sided pane changes no pixel; for a body it turns inside to outside.
TEST(Interface, NormalsOnTheFarSideAreFlipped) {
    const vec3 in(downwards(30));
    const glsl::Interface outside = glsl::interfaceMet(in, kUp, 1.5f);
    const glsl::Interface inside = glsl::interfaceMet(in, -kUp, 1.5f);
    EXPECT_EQ(outside.normal, inside.normal);
    EXPECT_EQ(outside.eta, 1.5f);
    EXPECT_EQ(inside.eta, 1.0f / 1.5f);
    EXPECT_EQ(glsl::interfaceMet(in, kUp, 1.0f).eta, glsl::interfaceMet(in, -kUp, 1.0f).eta);
    // A back normal from an image may point either way; the ray leaves in both cases.
    EXPECT_EQ(glsl::refractedOut(in, kUp, 1.5f).direction,
              glsl::refractedOut(in, -kUp, 1.5f).direction);
    EXPECT_EQ(glsl::refractedOut(in, kUp, 1.5f).direction,
              glsl::refractedAtSurface(in, -kUp, 1.5f).direction);
}

// Snell's window: half-angle asin(1 / 1.5) = 41.81 degrees, a mirror outside it, and Fresnel
// agrees.
TEST(Interface, TotalReflectionOutsideSnellsWindow) {
    for (double degrees = 0.0; degrees <= 90.0; degrees += 0.01) {
        const vec3 up(-downwards(degrees));
        const glsl::Refraction out = glsl::refractedAtSurface(up, kUp, 1.5f);
        EXPECT_EQ(out.total, degrees > 41.8103) << degrees;
        const float fresnel = glsl::fresnelDielectric(glm::dot(up, kUp), 1.0f / 1.5f);
        EXPECT_EQ(out.total, fresnel >= 1.0f) << degrees;
        if (out.total) {
            EXPECT_NEAR(glm::distance(out.direction, glm::reflect(up, kUp)), 0.0f, 1e-6f);
        }
    }
}

TEST(Interface, DirectionsAreNormalised) {
    for (const float ior : {0.0f, 0.3f, 0.999999f, 1.0f, 1.000001f, 1.5f, 3.0f, kInf}) {
        for (double degrees = 0.0; degrees <= 180.0; degrees += 0.01) {
            const vec3 in(downwards(degrees));
            for (const vec3& direction :
                 {glsl::refractedAtSurface(in, kUp, ior).direction,
                  glsl::refractedOut(in, kUp, ior).direction,
                  glsl::throughPane(in, glsl::interfaceMet(in, kUp, ior).normal, ior, 0.01f)
                      .direction,
                  glsl::throughBall(in, glsl::interfaceMet(in, kUp, ior).normal, ior, 0.01f)
                      .direction}) {
                ASSERT_NEAR(glm::length(direction), 1.0f, 1e-3f) << ior << " at " << degrees;
            }
        }
    }
    EXPECT_EQ(glm::length(glsl::refracted(vec3(0.0f), kUp, 1.5f).direction), 1.0f);
}

TEST(Interface, IndexOneIsInvisible) {
    for (double degrees = 0.0; degrees <= 90.0; degrees += 0.5) {
        const vec3 in(downwards(degrees));
        EXPECT_EQ(glsl::refractedAtSurface(in, kUp, 1.0f).direction, in);
        EXPECT_EQ(glsl::refractedAtSurface(-in, kUp, 1.0f).direction, -in);
        EXPECT_EQ(glsl::throughPane(in, kUp, 1.0f, 0.1f).direction, in);
        EXPECT_EQ(glsl::throughBall(in, kUp, 1.0f, 0.1f).direction, in);
        EXPECT_EQ(glsl::paneShift(std::max(0.0f, -in.y), 1.0f, 0.1f), 0.0f);
        EXPECT_EQ(glsl::glassSpread(1.0f, -in.y, 1.0f), 0.0f);
        EXPECT_FALSE(glsl::refractedAtSurface(in, kUp, 1.0f).total);
    }
}

// ---- shares (G3, G4, G7) -----------------------------------------------------------------------

float faceFresnel(double degrees, double ior) {
    return glsl::fresnelDielectric(float(std::cos(radians(degrees))), float(ior));
}

// Fresnel's amplitudes (Born and Wolf), each polarisation with all its bounces.
double polarisedPane(double degrees, double eta) {
    const double c = std::cos(radians(degrees));
    const double inner = std::sqrt(1.0 - (1.0 - c * c) / (eta * eta));
    const double s = std::pow((c - eta * inner) / (c + eta * inner), 2.0);
    const double p = std::pow((eta * c - inner) / (eta * c + inner), 2.0);
    return 0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p));
}

TEST(Pane, TransmittanceOfWindowGlass) {
    const std::vector<std::pair<double, double>> table{
        {0, 0.923}, {45, 0.907}, {60, 0.848}, {80, 0.459}, {89, 0.051}};
    for (const auto& [degrees, truth] : table) {
        EXPECT_NEAR(polarisedPane(degrees, 1.5), truth, 6e-4) << degrees;
        const glsl::GlassShares pane = glsl::paneShares(faceFresnel(degrees, 1.5), vec3(1.0f));
        EXPECT_NEAR(pane.transmitted.x, truth, 0.02) << degrees;
    }
    // At 89 degrees a clear pane is a mirror (G7).
    EXPECT_GT(glsl::paneShares(faceFresnel(89, 1.5), vec3(1.0f)).reflected.x, 0.9f);
}

TEST(Glass, EnergyIsConserved) {
    for (double ior = 1.0; ior <= 3.0; ior += 0.125) {
        for (double degrees = 0.0; degrees <= 89.99; degrees += 0.01) {
            for (const double eta : {ior, 1.0 / ior}) {
                const float fresnel = faceFresnel(degrees, eta);
                for (const glsl::GlassShares& shares : {glsl::paneShares(fresnel, vec3(1.0f)),
                                                        glsl::solidShares(fresnel, vec3(1.0f))}) {
                    ASSERT_NEAR(double(shares.reflected.y) + shares.transmitted.y, 1.0, 1e-6)
                        << eta << " at " << degrees;
                }
            }
        }
    }
}

// glTF: a metal and a dielectric by `metallic`, the dielectric clear and opaque by `transmission`.
TEST(Glass, OnlyTheDielectricPartTransmits) {
    for (double metallic = 0.0; metallic <= 1.0; metallic += 0.125) {
        for (double transmission = 0.0; transmission <= 1.0; transmission += 0.125) {
            const float t(transmission), m(metallic);
            const double clear = glsl::clearShare(t, m), rest = 1.0 - clear;
            const double metal = glsl::metallicBesideGlass(t, m);
            EXPECT_NEAR(clear, (1.0 - metallic) * transmission, 1e-6);
            EXPECT_NEAR(rest * metal, metallic, 1e-6) << metallic << " " << transmission;
            EXPECT_NEAR(rest * (1.0 - metal), (1.0 - metallic) * (1.0 - transmission), 1e-6);
        }
    }
    EXPECT_EQ(glsl::metallicBesideGlass(1.0f, 0.0f), 0.0f);
}

TEST(Pane, ErrorOfUnpolarisedFresnel) {
    double worst = 0.0, worstAt = 0.0;
    for (double degrees = 0.0; degrees < 90.0; degrees += 0.1) {
        const glsl::GlassShares pane = glsl::paneShares(faceFresnel(degrees, 1.5), vec3(1.0f));
        const double off = std::abs(pane.transmitted.x - polarisedPane(degrees, 1.5));
        if (off > worst) worst = off, worstAt = degrees;
    }
    EXPECT_NEAR(worst, 0.0222, 0.0001);
    EXPECT_NEAR(worstAt, 73.8, 0.5);
}

// Bounce after bounce, added up in double.
TEST(Glass, MatchesTheSumOfAllReflections) {
    for (const double f : {0.0, 0.04, 0.3, 0.9, 0.999}) {
        for (const double a : {0.0, 0.2, 0.9, 1.0}) {
            double through = 0.0, back = f, solid = 0.0, left = (1.0 - f) * a;
            for (int i = 0; i < 100000; ++i, left *= f * a) {
                (i % 2 == 0 ? through : back) += left * (1.0 - f);
                solid += left * (1.0 - f);
            }
            const glsl::GlassShares pane = glsl::paneShares(float(f), vec3(float(a)));
            EXPECT_NEAR(pane.transmitted.z, through, 2e-6) << f << ' ' << a;
            EXPECT_NEAR(pane.reflected.z, back, 2e-6) << f << ' ' << a;
            EXPECT_NEAR(glsl::solidShares(float(f), vec3(float(a))).transmitted.x, solid, 2e-6);
        }
    }
}

TEST(Glass, CoefficientsAreFiniteAndAtMostOne) {
    for (const float f : hardCosines()) {
        for (const float a : hardCosines()) {
            for (const glsl::GlassShares& s : {glsl::paneShares(f, vec3(a, 1.0f, 0.0f)),
                                               glsl::solidShares(f, vec3(a, 1.0f, 0.0f))}) {
                for (int i = 0; i < 3; ++i) {
                    EXPECT_GE(s.reflected[i], 0.0f);
                    EXPECT_GE(s.transmitted[i], 0.0f);
                    EXPECT_LE(s.reflected[i] + s.transmitted[i], 1.0f + 1e-6f) << f << ' ' << a;
                }
            }
        }
    }
}

// ---- absorption --------------------------------------------------------------------------------

TEST(Absorption, IsThePowerOfThePath) {
    const vec3 color(0.9f, 0.5f, 0.01f);
    for (const float path : {0.0f, 0.001f, 0.3f, 1.0f, 7.0f}) {
        const vec3 left = glsl::absorption(color, 0.3f, path);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(left[i], std::pow(double(color[i]), path / 0.3), 2e-6) << path;
        }
    }
    EXPECT_NEAR(glsl::absorption(color, 0.3f, 0.3f).x, color.x, 1e-6f);
    // Two paths one after the other are one long path.
    const vec3 twice = glsl::absorption(color, 2.0f, 0.7f) * glsl::absorption(color, 2.0f, 0.4f);
    EXPECT_NEAR(glm::distance(twice, glsl::absorption(color, 2.0f, 1.1f)), 0.0f, 1e-6f);
}

TEST(Absorption, LimitCases) {
    const vec3 color(0.5f, 0.0f, 1.0f);
    EXPECT_EQ(glsl::absorption(color, 1.0f, 0.0f), vec3(1.0f));
    for (const float distance : {0.0f, -1.0f, kInf, kNaN}) {
        EXPECT_EQ(glsl::absorption(color, distance, 5.0f), vec3(1.0f)) << distance;
    }
    EXPECT_EQ(glsl::absorption(color, 1.0f, 1.0f), vec3(0.5f, 0.0f, 1.0f));
    EXPECT_EQ(glsl::absorption(color, 1.0f, kInf), vec3(0.0f, 0.0f, 1.0f));
    EXPECT_EQ(glsl::absorption(color, 1e-38f, 1e30f), vec3(0.0f, 0.0f, 1.0f));
    EXPECT_EQ(glsl::absorption(color, 1.0f, kNaN), vec3(1.0f));
    EXPECT_EQ(glsl::absorption(vec3(2.0f), 1.0f, 3.0f), vec3(1.0f)) << "no medium adds light";
}

// ---- ways through ------------------------------------------------------------------------------

TEST(Pane, RaysLeaveParallelWithAnOffset) {
    for (const double index : kIndices) {
        for (double degrees = 0.0; degrees < 89.9; degrees += 0.5) {
            // The value in float: near grazing and index 1 its last bits matter.
            const float ior = float(index);
            const vec3 ray(downwards(degrees));
            const dvec3 in = glm::normalize(dvec3(ray));
            const glsl::Crossing c = glsl::throughPane(ray, kUp, ior, 0.1f);
            EXPECT_EQ(c.direction, ray);
            EXPECT_NEAR(c.offset.y, -0.1f, 1e-6f) << "the exit is on the other face";
            EXPECT_NEAR(glm::length(c.offset) / c.path, 1.0f, 1e-6f);
            // Geometry in double: where the bent ray crosses the second face, seen along the ray.
            const double sine = in.x / ior, cosine = std::sqrt(1.0 - sine * sine);
            const double shift = 0.1 * (in.x * cosine + in.y * sine) / cosine;
            EXPECT_NEAR(c.path * cosine / 0.1, 1.0, 1e-5) << ior << " at " << degrees;
            EXPECT_NEAR(glsl::paneShift(-ray.y, ior, 0.1f), shift, 1e-6)
                << ior << " at " << degrees;
            const dvec3 offset(c.offset);
            EXPECT_NEAR(glm::length(offset - in * glm::dot(offset, in)), shift, 1e-6)
                << ior << " at " << degrees;
        }
    }
    EXPECT_EQ(glsl::throughPane(vec3(downwards(50)), kUp, 1.5f, 0.0f).path, 0.0f);
}

TEST(Ball, RefractsTwice) {
    const double radius = 0.35;
    for (const double ior : kIndices) {
        for (double degrees = 0.0; degrees < 89.9; degrees += 0.25) {
            const dvec3 in = downwards(degrees);
            const glsl::Crossing c =
                glsl::throughBall(vec3(in), kUp, float(ior), float(2.0 * radius));
            const double inner = std::asin(std::sin(radians(degrees)) / ior);
            // From the float's own sine, as the arc sine is steep towards grazing.
            EXPECT_NEAR(angleBetween(in, dvec3(c.direction)), 2.0 * (radians(degrees) - inner),
                        3e-4)
                << ior << " at " << degrees;
            EXPECT_NEAR(c.path, 2.0 * radius * std::cos(inner), 1e-5);
            const dvec3 exit = dvec3(0, radius, 0) + dvec3(c.offset);  // the centre is the origin
            EXPECT_NEAR(glm::length(exit), radius, 1e-6) << ior << " at " << degrees;
            // The second interface by itself: in and out of a body with this back normal.
            const glsl::Refraction out =
                glsl::refractedOut(c.inside, vec3(glm::normalize(exit)), float(ior));
            if (degrees > 89.0) continue;  // the general way may see total reflection by rounding
            EXPECT_FALSE(out.total);
            EXPECT_NEAR(angleBetween(dvec3(out.direction), dvec3(c.direction)), 0.0, 5e-4)
                << ior << " at " << degrees;
        }
    }
}

TEST(Ball, KnownDeviationAtSixtyDegrees) {
    const dvec3 in = downwards(60);
    const glsl::Crossing c = glsl::throughBall(vec3(in), kUp, 1.5f, 1.0f);
    EXPECT_NEAR(angleBetween(in, dvec3(c.direction)) * 180.0 / kTruePi, 49.47, 0.01);
    EXPECT_NEAR(angleBetween(in, dvec3(c.inside)) * 180.0 / kTruePi, 24.74, 0.01);
}

TEST(Solid, IsABallIfItsThicknessMatchesTheCurvature) {
    EXPECT_EQ(glsl::ballShare(2.0f, 1.0f), 1.0f);
    EXPECT_EQ(glsl::ballShare(1.6f, 1.0f), 1.0f);
    EXPECT_EQ(glsl::ballShare(0.02f, 1.0f), 0.0f);  // a bottle
    EXPECT_EQ(glsl::ballShare(5.0f, 0.0f), 0.0f);   // a box
    EXPECT_EQ(glsl::ballShare(1.0f, 1.0f), 0.5f);
    for (const float hard : {-1.0f, 0.0f, 1e-30f, 1e30f, kInf}) {
        const float share = glsl::ballShare(hard, 1e5f);
        EXPECT_TRUE(share >= 0.0f && share <= 1.0f) << hard;
    }
}

TEST(Solid, ExitDirectionIsBetweenPaneAndBall) {
    const vec3 normal(0.0f, 1.0f, 0.0f);
    for (const double degrees : {0.0, 20.0, 60.0, 89.0}) {
        const vec3 incident(downwards(degrees));
        const auto pane = glsl::throughPane(incident, normal, 1.5f, 0.3f);
        const auto ball = glsl::throughBall(incident, normal, 1.5f, 0.3f);
        EXPECT_LT(angleBetween(glsl::crossingBetween(pane, ball, 0.0f).direction, pane.direction),
                  1e-6);
        EXPECT_LT(angleBetween(glsl::crossingBetween(pane, ball, 1.0f).direction, ball.direction),
                  1e-6);
        const auto between = glsl::crossingBetween(pane, ball, 0.5f);
        EXPECT_NEAR(glm::length(between.direction), 1.0f, 1e-6f);
        EXPECT_NEAR(between.path, 0.5f * (pane.path + ball.path), 1e-6f);
    }
}

// ---- rough glass -------------------------------------------------------------------------------

// Width that holds the middle half of the values.
double middleHalf(std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return values[values.size() * 3 / 4] - values[values.size() / 4];
}

// Light through a pane with two rough faces, facet by facet, in double by the textbook's Snell. The
// middle half of GGX slopes is 2 / sqrt(3) alpha wide, so the spread predicts both widths' mean.
TEST(RoughGlass, SpreadMatchesSampling) {
    const auto bent = [](const dvec3& in, const dvec3& n, double eta) {
        const double c = -glm::dot(in, n), k = 1.0 - (1.0 - c * c) / (eta * eta);
        return in / eta + n * (c / eta - std::sqrt(std::max(k, 0.0)));
    };
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    const auto facet = [&](float alpha) {
        return dvec3(glsl::ggxHalfVector({unit(random), unit(random)}, alpha));
    };
    for (const float ior : {1.2f, 1.5f, 2.0f}) {
        for (const double degrees : {0.0, 30.0, 50.0}) {
            const float alpha = 0.02f;
            const double sine = std::sin(radians(degrees)), cosine = std::cos(radians(degrees));
            std::vector<double> across, within;
            for (int i = 0; i < 40000; ++i) {
                const dvec3 in(sine, 0.0, -cosine);
                const dvec3 out = bent(bent(in, facet(alpha), ior), facet(alpha), 1.0 / ior);
                across.push_back(out.y);
                within.push_back(out.x * cosine + out.z * sine);
            }
            const double measured = std::sqrt(middleHalf(across) * middleHalf(within));
            const double predicted =
                2.0 / std::sqrt(3.0) * glsl::glassSpread(alpha, float(cosine), ior);
            EXPECT_NEAR(measured / predicted, 1.0, 0.06) << ior << " at " << degrees;
        }
    }
}

TEST(RoughGlass, GrowsWithRoughnessAndIndexAndStaysFinite) {
    for (const float cosine : hardCosines()) {
        for (const float ior : {0.0f, 0.5f, 1.0f, 1.5f, 3.0f, kInf}) {
            EXPECT_EQ(glsl::glassSpread(0.0f, cosine, ior), 0.0f);
            float before = 0.0f;
            for (float alpha = 0.0f; alpha <= 1.0f; alpha += 0.01f) {
                const float now = glsl::glassSpread(alpha, cosine, ior);
                ASSERT_TRUE(std::isfinite(now) && now >= before);
                before = now;
            }
        }
    }
    EXPECT_LT(glsl::glassSpread(0.1f, 1.0f, 1.2f), glsl::glassSpread(0.1f, 1.0f, 1.5f));
}

}  // namespace
}  // namespace clerestory::test
