// Every shading formula in float compared with itself in double, over grids with difficult values.
// Software drivers hide faults (max(NaN, 0) is 0 there, NaN * 0 is folded away), so frames without
// errors prove little; these tests do. Figures are relative to the required precision of the
// formula's result.
#include "tests/stability/table.h"
#include "tests/stability/twins.h"

#include <algorithm>
#include <random>

namespace clerestory::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec2;
using glm::vec3;

constexpr const char* kRow = "non-finite scan";

template <class F, class D>
double apart(const F& single, const D& twice) {
    if constexpr (std::is_arithmetic_v<F>) {
        return std::abs(double(single) - twice);
    } else {
        double most = 0.0;
        for (int i = 0; i < F::length(); ++i) {
            const double d = std::abs(double(single[i]) - twice[i]);
            if (!(d <= most)) most = d;  // NaN stays
        }
        return most;
    }
}

std::vector<float> cosines() {
    std::vector<float> values = hardCosines();
    for (int i = 0; i <= steps(60, 2000); ++i) {
        values.push_back(float(std::cos(radians(90.0 * i / steps(60, 2000)))));
    }
    for (const double degrees : {89.0, 89.9, 89.99, 89.9999}) {
        values.push_back(float(std::cos(radians(degrees))));
    }
    return values;
}
std::vector<float> roughnesses() {
    std::vector<float> values{0.0f, 1e-20f, 1e-6f, 1e-3f, 0.0449f, 0.045f, 0.0451f};
    for (int i = 0; i <= steps(50, 400); ++i) values.push_back(float(i) / float(steps(50, 400)));
    return values;
}
const std::vector<float>& indices() {
    static const std::vector<float> values{1.0f,     1.0000005f, 1.000002f, 1.0003f, 1.1f,
                                           1.33f,    1.5f,       2.42f,     3.0f,    1.0f / 1.33f,
                                           1 / 1.5f, 1 / 2.42f,  1 / 3.0f};
    return values;
}
// Off the plane by a little, and of all directions.
std::vector<vec3> directions() {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    std::vector<vec3> all{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    all.push_back(glm::normalize(vec3(1.0f, 1e-7f, 0.0f)));
    all.push_back(glm::normalize(vec3(1e-20f, 1.0f, -1e-4f)));
    for (int i = 0; i < steps(200, 5000); ++i) {
        all.push_back(glm::normalize(vec3(normal(random), normal(random), normal(random))));
    }
    return all;
}

TEST(Twins, FresnelOfDielectrics) {
    for (const float eta : indices()) {
        for (const float c : cosines()) {
            const double exact = twin::fresnelDielectric(c, eta);
            const float single = glsl::fresnelDielectric(c, eta);
            // At the critical angle and at index 1 the curve is upright: rounding of the argument
            // moves the result by its slope, which goes with 1 / g.
            const double clamped = std::clamp(double(c), 0.0, 1.0);
            const double g2 = (double(eta) - 1.0) * (double(eta) + 1.0) + clamped * clamped;
            const double slope = g2 > 0.0 ? std::min(1.0, std::sqrt(g2)) : 1.0;
            // A root within rounding of 0 may fall to either side.
            if (std::abs(g2) < 1e-6) continue;
            EXPECT_TRUE(atMost(kRow, "fresnelDielectric, x g", apart(single, exact) * slope, 1e-6))
                << "eta " << eta << " cosine " << c;
            EXPECT_TRUE(single >= 0.0f && single <= 1.0f);
        }
    }
}

TEST(Twins, RefractedDirections) {
    const vec3 up(0.0f, 1.0f, 0.0f);
    for (const float eta : indices()) {
        for (const float c : cosines()) {
            if (!(c >= 0.0f && c <= 1.0f)) continue;
            const vec3 in(std::sqrt(1.0f - c * c), -c, 0.0f);
            const auto single = glsl::refracted(in, up, eta);
            const auto exact = twin::refracted(dvec3(in), dvec3(up), double(eta));
            const double g2 = (double(eta) - 1.0) * (double(eta) + 1.0) + double(c) * c;
            if (std::abs(g2) < 1e-6) continue;
            EXPECT_EQ(single.total, exact.total) << eta << ' ' << c;
            EXPECT_TRUE(atMost(
                kRow, "refracted, x g",
                apart(single.direction, exact.direction) * std::min(1.0, std::sqrt(std::abs(g2))),
                1e-6))
                << "eta " << eta << " cosine " << c;
            EXPECT_NEAR(glm::length(single.direction), 1.0f, 2e-6f);
        }
    }
}

TEST(Twins, GgxLobe) {
    for (const float roughness : roughnesses()) {
        const float alpha = roughness * roughness;
        for (int i = 0; i <= 60; ++i) {
            const double angle = radians(i < 40 ? 0.01 * i * i : 16.0 + 3.6 * (i - 40));
            const vec3 n(0.0f, 0.0f, 1.0f);
            const vec3 h(vec2(float(std::sin(angle)), 0.0f), float(std::cos(angle)));
            const vec3 across = glm::cross(n, h);
            const float d = glsl::ggxDistribution(glm::dot(n, h), glm::dot(across, across), alpha);
            const dvec3 far = glm::cross(dvec3(n), dvec3(h));
            const double exact =
                twin::ggxDistribution(glm::dot(dvec3(n), dvec3(h)), glm::dot(far, far), alpha);
            EXPECT_TRUE(
                atMost(kRow, "ggxDistribution, relative", apart(d, exact) / (exact + 1e-9), 1e-5))
                << "roughness " << roughness << " angle " << angle;
        }
        for (const float l : cosines()) {
            for (const float v : hardCosines()) {
                const double exact = twin::ggxVisibility(l, v, alpha);
                EXPECT_TRUE(atMost(kRow, "ggxVisibility, relative",
                                   apart(glsl::ggxVisibility(l, v, alpha), exact) / exact, 2e-6))
                    << l << ' ' << v << ' ' << alpha;
            }
        }
    }
}

TEST(Twins, EnvironmentLight) {
    for (const float f0 : {0.0f, 0.04f, 0.5f, 1.0f}) {
        for (int i = 0; i <= 20; ++i) {
            for (int j = 0; i + j <= 20; ++j) {
                const vec2 ab(float(i) / 20.0f, float(j) / 20.0f);
                const vec3 single = glsl::specularEnvironment(vec3(f0), 1.0f, ab);
                const dvec3 exact = twin::specularEnvironment(dvec3(double(f0)), 1.0, dvec2(ab));
                EXPECT_TRUE(atMost(kRow, "specularEnvironment", apart(single, exact), 2e-6));
                EXPECT_TRUE(atMost(kRow, "diffuseWeight",
                                   apart(glsl::diffuseWeight(single), twin::diffuseWeight(exact)),
                                   2e-6));
            }
        }
    }
    for (const vec3& n : directions()) {
        const vec3 c[9] = {vec3(1.0f), n,        n * 0.5f, vec3(0.2f), -n * 0.3f,
                           n * n,      n * 0.1f, -n * n,   vec3(0.4f)};
        const dvec3 d[9] = {dvec3(c[0]), dvec3(c[1]), dvec3(c[2]), dvec3(c[3]), dvec3(c[4]),
                            dvec3(c[5]), dvec3(c[6]), dvec3(c[7]), dvec3(c[8])};
        EXPECT_TRUE(atMost(
            kRow, "harmonics9",
            apart(glsl::harmonics9(n, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8]),
                  twin::harmonics9(dvec3(n), d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7], d[8])),
            2e-6));
    }
}

TEST(Twins, GlassBodies) {
    const std::vector<float> clears{0.0f, 1e-30f, 0.1f, 0.999f, 1.0f};
    for (int i = 0; i <= steps(200, 4000); ++i) {
        const float fresnel = float(i) / float(steps(200, 4000));
        for (const float clear : clears) {
            const auto pane = glsl::paneShares(fresnel, vec3(clear));
            const auto solid = glsl::solidShares(fresnel, vec3(clear));
            const auto exactPane = twin::paneShares(fresnel, dvec3(double(clear)));
            const auto exactSolid = twin::solidShares(fresnel, dvec3(double(clear)));
            const double most = std::max({apart(pane.reflected, exactPane.reflected),
                                          apart(pane.transmitted, exactPane.transmitted),
                                          apart(solid.reflected, exactSolid.reflected),
                                          apart(solid.transmitted, exactSolid.transmitted)});
            EXPECT_TRUE(atMost(kRow, "paneShares, solidShares", most, 1e-6)) << fresnel << clear;
        }
    }
    for (const float color : clears) {
        for (const float distance : {0.0f, 1e-38f, 1e-3f, 1.0f, 1e18f, kInf}) {
            for (const float path : {0.0f, 1e-20f, 1e-3f, 1.0f, 100.0f, 1e18f, kInf}) {
                EXPECT_TRUE(atMost(kRow, "absorption",
                                   apart(glsl::absorption(vec3(color), distance, path),
                                         twin::absorption(dvec3(double(color)), distance, path)),
                                   1e-5))
                    << color << ' ' << distance << ' ' << path;
            }
        }
    }
    for (const float roughness : roughnesses()) {
        for (const float c : cosines()) {
            for (const float ior : indices()) {
                const double exact = twin::glassSpread(roughness * roughness, c, ior);
                EXPECT_TRUE(atMost(
                    kRow, "glassSpread, relative",
                    apart(glsl::glassSpread(roughness * roughness, c, ior), exact) / (1.0 + exact),
                    2e-6));
            }
        }
    }
}

TEST(Twins, WhereReflectionsAreLookedUp) {
    for (const float roughness : roughnesses()) {
        for (const float size : {1.0f, 16.0f, 777.0f, 4096.0f}) {
            EXPECT_TRUE(atMost(kRow, "environmentLod",
                               apart(glsl::environmentLod(roughness, size, 12.0f),
                                     twin::environmentLod(roughness, size, 12.0)),
                               4e-6));
            for (const float near : {0.0f, 1e-20f, 0.3f, 1e6f, kInf}) {
                for (const float far : {0.0f, 1e-20f, 0.7f, 1e6f, kInf}) {
                    EXPECT_TRUE(atMost(kRow, "mirrorLod",
                                       apart(glsl::mirrorLod(roughness, size, near, far),
                                             twin::mirrorLod(roughness, size, near, far)),
                                       4e-6))
                        << roughness << ' ' << near << ' ' << far;
                }
            }
        }
    }
    const vec3 low(-1.0f, -2.0f, -0.5f), high(3.0f, 1.0f, 0.5f);
    for (const vec3& along : directions()) {
        for (const vec3& at : {vec3(0.0f), vec3(2.9f, 0.9f, 0.4f), vec3(3.0f, 1.0f, 0.5f),
                               vec3(-1.0f, 0.0f, 0.0f), vec3(9.0f)}) {
            EXPECT_TRUE(
                atMost(kRow, "boxParallax",
                       apart(glsl::boxParallax(at, along, low, high),
                             twin::boxParallax(dvec3(at), dvec3(along), dvec3(low), dvec3(high))),
                       4e-6))
                << at.x << ' ' << along.x << ' ' << along.y << ' ' << along.z;
            EXPECT_TRUE(
                atMost(kRow, "sphereParallax",
                       apart(glsl::sphereParallax(at, along, vec3(0.1f), 3.5f),
                             twin::sphereParallax(dvec3(at), dvec3(along), dvec3(vec3(0.1f)), 3.5)),
                       4e-6));
        }
    }
}

TEST(Twins, SamplesAndFrames) {
    for (const float roughness : roughnesses()) {
        for (unsigned i = 0; i < 64; ++i) {
            const vec2 u = glsl::hammersley(i, 64);
            const float alpha = roughness * roughness;
            EXPECT_TRUE(atMost(
                kRow, "ggxHalfVector",
                apart(glsl::ggxHalfVector(u, alpha), twin::ggxHalfVector(dvec2(u), alpha)), 2e-6));
        }
    }
    for (const vec3& n : directions()) {
        const glm::mat3 single = glsl::frameAbout(n);
        const glm::dmat3 exact = twin::frameAbout(dvec3(n));
        for (int i = 0; i < 3; ++i) {
            EXPECT_TRUE(atMost(kRow, "frameAbout", apart(single[i], exact[i]), 1e-6));
        }
    }
}

TEST(Twins, ToneCurves) {
    for (double radiance = 1e-8; radiance < 1e5; radiance *= longForm() ? 1.003 : 1.1) {
        const float r = float(radiance);
        for (const vec3& tint : {vec3(1.0f), vec3(1.0f, 0.0f, 0.3f), vec3(0.01f, 1.0f, 0.9f)}) {
            const vec3 c = r * tint;
            const dvec3 d(c);
            const double most = std::max({apart(glsl::toneMapNeutral(c), twin::toneMapNeutral(d)),
                                          apart(glsl::toneMapAces(c), twin::toneMapAces(d)),
                                          apart(glsl::toneMapLinear(c), twin::toneMapLinear(d))});
            EXPECT_TRUE(atMost(kRow, "tone curves", most, 2e-6)) << radiance;
            EXPECT_TRUE(atMost(kRow, "srgbFromLinear",
                               apart(glsl::srgbFromLinear(c), twin::srgbFromLinear(d)), 1e-6));
        }
    }
}

}  // namespace
}  // namespace clerestory::test
