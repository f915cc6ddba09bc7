// Formulae of material layers compared with sums in double: over the hemisphere and the spectrum.
#include "reference/layers.h"
#include "optics_support.h"
#include "reference/bsdf.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace clerestory::test {
namespace {

// Sum of lobe(l, half) times the cosine over the hemisphere; v in the plane y = 0.
template <class Lobe>
double overHemisphere(const glm::dvec3& v, const Lobe& lobe, int steps = 512) {
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double root = (i + 0.5) / steps, z = root * root, s = std::sqrt(1.0 - z * z);
        for (int j = 0; j < 2 * steps; ++j) {
            const double turn = 2.0 * kTruePi * (j + 0.5) / (2 * steps);
            const glm::dvec3 l(s * std::cos(turn), s * std::sin(turn), z);
            sum += lobe(l, glm::normalize(l + v)) * 2.0 * root;
        }
    }
    return sum * kTruePi / (double(steps) * steps);
}

TEST(Sheen, AlbedoIsTheSumOfTheLobe) {
    double squares = 0.0;
    int count = 0;
    for (const double roughness : {0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 1.0}) {
        for (const double c : {0.08, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0}) {
            const glm::dvec3 v(std::sqrt(1.0 - c * c), 0.0, c);
            const double sum = overHemisphere(
                v,
                [&](const glm::dvec3& l, const glm::dvec3& half) {
                    return double(
                        glsl::sheenLobe(float(l.z), float(c), float(half.z), float(roughness)));
                },
                128);
            const double fitted = glsl::sheenAlbedo(float(c), float(roughness));
            EXPECT_NEAR(fitted, sum, 0.04) << roughness << ' ' << c;
            EXPECT_NEAR(reference::sheenAlbedo(c, roughness), sum, 0.02) << roughness << ' ' << c;
            EXPECT_LE(sum, 1.0) << roughness << ' ' << c;
            squares += (fitted - sum) * (fitted - sum);
            ++count;
        }
    }
    EXPECT_LT(std::sqrt(squares / count), 0.015);
}

// Of a direction l of the lobe: the means of l, of its products, and of what harmonics make of
// both.
TEST(Sheen, SpreadIsThatOfTheLobe) {
    for (const double roughness : {0.2, 0.35, 0.5, 0.7, 1.0}) {
        for (const double c : {0.1, 0.3, 0.5, 0.8}) {
            const glm::dvec3 v(std::sqrt(1.0 - c * c), 0.0, c);
            const auto sumOf = [&](const auto& f) {
                return overHemisphere(
                    v,
                    [&](const glm::dvec3& l, const glm::dvec3& half) {
                        return f(l) * double(glsl::sheenLobe(float(l.z), float(c), float(half.z),
                                                             float(roughness)));
                    },
                    128);
            };
            const double whole = sumOf([](const glm::dvec3&) { return 1.0; });
            if (whole < 0.05) continue;
            const glm::vec2 axis = glsl::sheenAxis(float(c), float(roughness));
            EXPECT_NEAR(axis.x, sumOf([](const glm::dvec3& l) { return l.x; }) / whole, 0.04);
            EXPECT_NEAR(axis.y, sumOf([](const glm::dvec3& l) { return l.z; }) / whole, 0.04);
            // The axes of the two parts are z and the middle between x and z.
            const glm::vec2 parts = glsl::sheenSpread(axis);
            const double zz = (1.0 + 2.0 * double{parts.x} + 0.5 * double{parts.y}) / 3.0;
            const double xz = 0.5 * double{parts.y};
            EXPECT_NEAR(zz, sumOf([](const glm::dvec3& l) { return l.z * l.z; }) / whole, 0.04)
                << roughness << ' ' << c;
            EXPECT_NEAR(xz, sumOf([](const glm::dvec3& l) { return l.x * l.z; }) / whole, 0.04)
                << roughness << ' ' << c;
        }
    }
}

TEST(Sheen, IsFiniteForEveryInput) {
    for (const float l : hardCosines()) {
        for (const float v : hardCosines()) {
            for (const float h : hardCosines()) {
                for (const float r : {0.0f, 1e-6f, 0.3f, 1.0f}) {
                    const float lobe = glsl::sheenLobe(l, v, h, r);
                    EXPECT_TRUE(std::isfinite(lobe) && lobe >= 0.0f) << l << ' ' << v << ' ' << h;
                    const float albedo = glsl::sheenAlbedo(v, r);
                    EXPECT_TRUE(albedo >= 0.0f && albedo <= 1.0f) << v << ' ' << r;
                }
            }
        }
    }
}

// The fit with Gaussians against Airy's formula for both polarisations, summed over the spectrum.
// The rest is higher orders of interference, and saturated colours of bright bases, which the two
// clamp to the gamut differently.
TEST(ThinFilm, MatchesTheSumOverTheSpectrum) {
    double squares = 0.0, greatest = 0.0;
    int count = 0;
    for (const double ior : {1.2, 1.33, 1.6, 1.8}) {
        for (const double thickness : {0.0, 100.0, 180.0, 260.0, 400.0, 650.0, 1000.0}) {
            for (const double f0 : {0.02, 0.04, 0.2, 0.6, 0.95}) {
                for (const double c : {0.05, 0.1, 0.2, 0.35, 0.6, 0.8, 1.0}) {
                    const glm::vec3 fit = glsl::filmReflectance(
                        float(c), float(ior), float(thickness), glm::vec3(float(f0)));
                    const glm::dvec3 sum =
                        reference::filmReflectance(c, ior, thickness, glm::dvec3(f0));
                    for (int i = 0; i < 3; ++i) {
                        const double off = fit[i] - sum[i];
                        squares += off * off;
                        greatest = std::max(greatest, std::abs(off));
                        ++count;
                    }
                }
            }
        }
    }
    RecordProperty("rms", std::to_string(std::sqrt(squares / count)));
    RecordProperty("greatest", std::to_string(greatest));
    EXPECT_LT(std::sqrt(squares / count), 0.02);
    EXPECT_LT(greatest, 0.2);
}

// A film of no thickness, and one with the index of the base, changes nothing.
TEST(ThinFilm, OfNoThicknessIsTheBase) {
    for (const float c : {0.3f, 0.7f, 1.0f}) {
        for (const float f0 : {0.04f, 0.5f, 0.9f}) {
            const float index = (1.0f + std::sqrt(f0)) / (1.0f - std::sqrt(f0));
            const float base = glsl::fresnelDielectric(c, index);
            EXPECT_NEAR(glsl::filmReflectance(c, 1.6f, 0.0f, glm::vec3(f0)).x, base, 0.02f);
            const glm::dvec3 exact = reference::filmReflectance(1.0, index, 300.0, glm::dvec3(f0));
            EXPECT_NEAR(exact.x, f0, 1e-6);
        }
    }
}

TEST(ThinFilm, IsFiniteAndAtMostOne) {
    for (const float c : hardCosines()) {
        for (const float thickness : {0.0f, 1e-3f, 500.0f, 1e5f}) {
            for (const float f0 : {0.0f, 0.04f, 1.0f}) {
                for (const float ior : {1.0f, 1.33f, 10.0f}) {
                    const glm::vec3 r = glsl::filmReflectance(c, ior, thickness, glm::vec3(f0));
                    for (int i = 0; i < 3; ++i) EXPECT_TRUE(r[i] >= 0.0f && r[i] <= 1.0f);
                    const glm::vec3 back = glsl::f0Through(r, 1.0f, c);
                    for (int i = 0; i < 3; ++i) EXPECT_TRUE(back[i] >= 0.0f && back[i] <= 1.0f);
                }
            }
        }
    }
}

TEST(ThinFilm, SchlicksCurvePassesThroughItsReflectance) {
    for (const float c : {0.4f, 0.7f, 1.0f}) {
        for (const float r : {0.3f, 0.5f, 0.9f}) {
            const glm::vec3 f0 = glsl::f0Through(glm::vec3(r), 1.0f, c);
            EXPECT_NEAR(glsl::fresnelSchlick(f0, glm::vec3(1.0f), c).x, r, 1e-5f);
        }
    }
}

// Equal alphas are the isotropic lobe; turned by a quarter, the alphas change places.
TEST(Grain, EqualAlphasAreIsotropic) {
    for (const double alpha : {0.01, 0.1, 0.5, 1.0}) {
        for (const double x : {0.0, 0.3, -0.6}) {
            const glm::dvec3 v = glm::normalize(glm::dvec3(0.4, 0.1, 0.8)),
                             l = glm::normalize(glm::dvec3(x, 0.2, 0.7)), h = glm::normalize(v + l);
            const float lobe = glsl::ggxAnisotropicLobe(glm::vec3(l), glm::vec3(v), glm::vec3(h),
                                                        glm::vec2(float(alpha)));
            const double expected = textbookDistribution(h.z, alpha) *
                                    textbookMaskingShadowing(l.z, v.z, alpha) / (4.0 * v.z);
            EXPECT_NEAR(lobe / expected, 1.0, 2e-3) << alpha << ' ' << x;
            const auto turned = [](const glm::dvec3& d) {
                return glm::vec3(float(-d.y), float(d.x), float(d.z));
            };
            EXPECT_FLOAT_EQ(
                glsl::ggxAnisotropicLobe(glm::vec3(l), glm::vec3(v), glm::vec3(h), {0.4f, 0.1f}),
                glsl::ggxAnisotropicLobe(turned(l), turned(v), turned(h), {0.1f, 0.4f}));
        }
    }
}

// Its albedo: the reference draws visible normals, the formula is summed over the hemisphere.
TEST(Grain, AlbedoMatchesSamplingOfVisibleNormals) {
    for (const glm::dvec2 alphas : {glm::dvec2(0.5, 0.2), glm::dvec2(1.0, 0.3)}) {
        for (const double c : {0.3, 0.7, 1.0}) {
            const glm::dvec3 v(std::sqrt(1.0 - c * c), 0.0, c);
            const double sum = overHemisphere(v, [&](const glm::dvec3& l, const glm::dvec3& half) {
                return double(glsl::ggxAnisotropicLobe(glm::vec3(l), glm::vec3(v), glm::vec3(half),
                                                       glm::vec2(alphas)));
            });
            double sampled = 0.0;
            constexpr int kSteps = 256;
            for (int i = 0; i < kSteps * kSteps; ++i) {
                const glm::dvec2 u((i % kSteps + 0.5) / kSteps, (i / kSteps + 0.5) / kSteps);
                const glm::dvec3 facet = reference::sampleVisibleNormal(v, alphas, u);
                const glm::dvec3 l = 2.0 * glm::dot(v, facet) * facet - v;
                if (l.z > 0.0)
                    sampled +=
                        reference::maskingShadowing(v, l, alphas) / reference::masking(v, alphas);
            }
            EXPECT_NEAR(sum, sampled / (kSteps * kSteps), 3e-3) << alphas.x << ' ' << c;
        }
    }
}

// KHR_materials_dispersion: an Abbe number of 55 and index 1.5168 (crown glass) has n_F - n_C =
// 0.0094.
TEST(Dispersion, SpreadsIndicesByTheAbbeNumber) {
    const glm::vec3 iors = glsl::dispersedIors(1.5168f, 20.0f / 55.0f);
    EXPECT_NEAR(iors.z - iors.x, 0.5168 / 55.0, 1e-4);
    EXPECT_FLOAT_EQ(iors.y, 1.5168f);
    EXPECT_GE(glsl::dispersedIors(1.05f, 1e6f).x, 1.0f);
}

}  // namespace
}  // namespace clerestory::test
