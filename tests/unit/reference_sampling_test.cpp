// The path tracer's sampling routines compared with their densities (Pearson's chi-square).
#include "reference/bsdf.h"
#include "reference/lights.h"
#include "reference/sampler.h"
#include "reference/scene_geometry.h"

#include <gtest/gtest.h>

#include <functional>

namespace clerestory::reference {
namespace {

using SampleFunction = std::function<glm::dvec3(const glm::dvec2&)>;
using Density = std::function<double(const glm::dvec3&)>;

constexpr int kRings = 24, kSectors = 32;  // of equal solid angle

// Independent numbers: low discrepancy would fit too well.
glm::dvec2 independent(std::uint64_t i) {
    return {double(mixBits(2 * i) >> 11) * 0x1p-53, double(mixBits(2 * i + 1) >> 11) * 0x1p-53};
}

// Expectations are integrals of the density over each bin. At five standard deviations a right
// sampler fails once in a million; the numbers are the same in every run.
void expectFits(const SampleFunction& sample, const Density& density) {
    constexpr int kSamples = 200000, kSteps = 24;
    std::vector<double> expected(kRings * kSectors), found(expected.size());
    double total = 0.0;
    for (int bin = 0; bin < kRings * kSectors; ++bin) {
        for (int i = 0; i < kSteps * kSteps; ++i) {
            const double z = -1.0 + 2.0 * (bin / kSectors + (i / kSteps + 0.5) / kSteps) / kRings;
            const double turn =
                2.0 * kPi * (bin % kSectors + (i % kSteps + 0.5) / kSteps) / kSectors;
            const double r = std::sqrt(1.0 - z * z);
            expected[bin] += density({r * std::cos(turn), r * std::sin(turn), z});
        }
        expected[bin] *= 4.0 * kPi / (kRings * kSectors * kSteps * kSteps);
        total += expected[bin];
    }
    EXPECT_NEAR(total, 1.0, 5e-3) << "the density's integral";
    for (int i = 0; i < kSamples; ++i) {
        const glm::dvec3 d = sample(independent(i));
        ASSERT_NEAR(glm::length(d), 1.0, 1e-9);
        const double turn = std::atan2(d.y, d.x) / (2.0 * kPi);
        const int ring = std::min(int((d.z + 1.0) / 2.0 * kRings), kRings - 1);
        const int sector = std::min(int((turn < 0 ? turn + 1 : turn) * kSectors), kSectors - 1);
        ++found[ring * kSectors + sector];
    }
    double chiSquare = 0.0, restExpected = 0.0, restFound = 0.0;
    int degrees = 0;
    for (std::size_t bin = 0; bin < expected.size(); ++bin) {
        const double e = expected[bin] / total * kSamples;
        if (e < 20.0) {  // too few to judge alone
            restExpected += e;
            restFound += found[bin];
            continue;
        }
        chiSquare += (found[bin] - e) * (found[bin] - e) / e;
        ++degrees;
    }
    if (restExpected > 5.0) {
        chiSquare += (restFound - restExpected) * (restFound - restExpected) / restExpected;
        ++degrees;
    }
    ASSERT_GT(degrees, 10);
    EXPECT_LT((chiSquare - degrees) / std::sqrt(2.0 * degrees), 5.0) << degrees << " bins";
}

TEST(ReferenceSampling, VisibleNormalsFitTheirDensity) {
    for (const double cosine : {0.99, 0.5, 0.1}) {
        for (const double alpha : {0.2, 0.5, 1.0}) {
            SCOPED_TRACE(testing::Message() << "cosine " << cosine << ", alpha " << alpha);
            const glm::dvec3 v(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
            expectFits([&](const glm::dvec2& r) { return sampleVisibleNormal(v, alpha, r); },
                       [&](const glm::dvec3& h) {
                           return h.z > 0.0 ? visibleNormalPdf(v, h, alpha) : 0.0;
                       });
        }
    }
}

TEST(ReferenceSampling, ReflectionsFitTheirDensity) {
    const glm::dvec3 v(0.6, 0.0, 0.8);
    expectFits(
        [&](const glm::dvec2& r) {
            const glm::dvec3 h = sampleVisibleNormal(v, 0.4, r);
            return 2.0 * glm::dot(v, h) * h - v;
        },
        [&](const glm::dvec3& l) { return reflectionPdf(v, l, 0.4); });
}

// Into glass and out of it, where steep facets reflect all light.
TEST(ReferenceSampling, RefractionsFitTheirDensity) {
    for (const double eta : {1.5, 1.0 / 1.5}) {
        constexpr double kAlpha = 0.2;
        const glm::dvec3 v = glm::normalize(glm::dvec3(0.25, 0.1, 1.0));
        const auto reflectsAll = [&](const glm::dvec3& facet) {
            return refractedCosine(glm::dot(v, facet), eta) < 0.0;
        };
        expectFits(
            [&](const glm::dvec2& u) {
                const glm::dvec3 facet = sampleVisibleNormal(v, kAlpha, u);
                return reflectsAll(facet) ? 2.0 * glm::dot(v, facet) * facet - v
                                          : refracted(-v, facet, eta);
            },
            [&](const glm::dvec3& l) {
                const double density = refractionPdf(v, l, kAlpha, eta);
                const glm::dvec3 facet = glm::normalize(v + l);
                return reflectsAll(facet) ? density + reflectionPdf(v, l, kAlpha) : density;
            });
    }
}

TEST(ReferenceSampling, CosineHemisphereFitsItsDensity) {
    expectFits(sampleCosineHemisphere, cosineHemispherePdf);
}

TEST(ReferenceSampling, EnvironmentFitsItsDensity) {
    for (const EnvironmentMap& map : {skyEnvironment(), studioEnvironment()}) {
        SCOPED_TRACE(map.name);
        const glm::dmat3 turned = glm::mat3_cast(glm::angleAxis(0.7, glm::dvec3(0.6, 0.0, 0.8)));
        EnvironmentLight light(map, turned, 2.0);
        light.prepareSampling();
        expectFits([&](const glm::dvec2& r) { return light.sample(r).direction; },
                   [&](const glm::dvec3& d) { return light.pdf(d); });
        const EnvironmentLight::Sample choice = light.sample({0.3, 0.6});
        EXPECT_NEAR(choice.pdf, light.pdf(choice.direction), 1e-9 * choice.pdf);
    }
}

TEST(ReferenceSampling, BlackEnvironmentsHaveDensityZero) {
    const EnvironmentMap black = constantEnvironment("black", glm::vec3(0.0f));
    EnvironmentLight light(black, glm::dmat3(1.0), 1.0);
    light.prepareSampling();
    EXPECT_EQ(light.sample({0.5, 0.5}).pdf, 0.0);
    EXPECT_EQ(light.pdf({0.0, 1.0, 0.0}), 0.0);
}

TEST(ReferenceSampling, SamplesAreStratified) {
    // Every elementary interval of area 1/256 contains one of 256 points.
    for (int shape = 0; shape <= 8; ++shape) {
        const int columns = 1 << shape, rows = 256 / columns;
        std::vector<int> hits(256);
        for (std::uint32_t i = 0; i < 256; ++i) {
            const glm::dvec2 p = Sampler(3, 7, i).get2D();
            ++hits[int(p.y * rows) * columns + int(p.x * columns)];
        }
        for (const int h : hits) EXPECT_EQ(h, 1) << columns << " columns";
    }
    EXPECT_NE(Sampler(3, 7, 0).get2D(), Sampler(4, 7, 0).get2D());
    EXPECT_NE(Sampler(3, 7, 0).get2D(), Sampler(3, 8, 0).get2D());
}

// The irradiance table against plain sums over directions.
TEST(ReferenceSampling, IrradianceIsTheIntegralOfTheEnvironment) {
    const EnvironmentMap map = skyEnvironment();
    EnvironmentLight light(map, glm::dmat3(1.0), 1.0);
    light.prepareIrradiance();
    for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(1, 0.2, -0.5)),
                                glm::normalize(glm::dvec3(0.3, -1, 0.1))}) {
        const Frame frame(n);
        glm::dvec3 sum(0.0);
        constexpr int kSamples = 1 << 16;
        for (std::uint32_t i = 0; i < kSamples; ++i) {
            sum += light.radiance(frame.toWorld(sampleCosineHemisphere(Sampler(1, 1, i).get2D())));
        }
        const glm::dvec3 expected = sum / double(kSamples), found = light.irradianceOverPi(n);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1.0, 4e-3);
    }
}

}  // namespace
}  // namespace clerestory::reference
