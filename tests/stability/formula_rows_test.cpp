// Rows of the stability table that depend on formulae only: furnaces, grazing angles, roughness,
// transforms of planes, the field of view, invalid meshes.
#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/geometry.h"
#include "tests/stability/table.h"
#include "tests/stability/twins.h"

#include <functional>
#include <random>

namespace clerestory::test {
namespace {

using glm::dvec3;
using glm::vec3;

TEST(FormulaRows, WhiteFurnace) {
    constexpr int kSize = 32;
    const auto table = environmentBrdfTable(kSize);
    const auto lookUp = [&](float nDotV, float roughness) {
        const glm::vec2 at =
            glsl::environmentBrdfCoordinate(nDotV, roughness, kSize) * float(kSize) - 0.5f;
        const int i = std::min(int(at.x), kSize - 2), j = std::min(int(at.y), kSize - 2);
        const auto entry = [&](int x, int y) { return table[std::size_t(y * kSize + x)]; };
        return glm::mix(glm::mix(entry(i, j), entry(i + 1, j), at.x - float(i)),
                        glm::mix(entry(i, j + 1), entry(i + 1, j + 1), at.x - float(i)),
                        at.y - float(j));
    };
    for (int m = 0; m <= 50; ++m) {
        for (int i = 0; i < 50; ++i) {
            const float roughness = float(m) / 50.0f, nDotV = 0.02f + 0.98f * float(i) / 49.0f;
            const glm::vec2 ab = lookUp(nDotV, roughness);
            for (const float f0 : {0.0f, 0.04f, 0.5f, 1.0f}) {
                const vec3 specular = glsl::specularEnvironment(vec3(f0), 1.0f, ab);
                EXPECT_TRUE(std::isfinite(specular.x));
                if (f0 == 1.0f) {
                    EXPECT_TRUE(atMost("white furnace", "|returned - 1|, F0 = 1, formula",
                                       std::abs(specular.x - 1.0), 0.01))
                        << roughness << ' ' << nDotV;
                }
                for (const float diffuse : {0.0f, 1.0f}) {
                    EXPECT_TRUE(atMost("white furnace", "returned, formula",
                                       specular.x + diffuse * glsl::diffuseWeight(specular),
                                       1.005));
                }
            }
        }
    }
}

TEST(FormulaRows, GlassFurnace) {
    for (int i = 0; i <= steps(20, 200); ++i) {
        const double ior = 1.0 + 2.0 * i / steps(20, 200);
        for (int j = 0; j <= steps(180, 900); ++j) {
            const double degrees = 89.9 * j / steps(180, 900);
            const float c = float(std::cos(radians(degrees)));
            // From within: the same interface with its index turned over.
            for (const float eta : {float(ior), float(1.0 / ior)}) {
                const float f = glsl::fresnelDielectric(c, eta);
                const auto pane = glsl::paneShares(f, vec3(1.0f));
                const auto solid = glsl::solidShares(f, vec3(1.0f));
                for (const auto& shares : {pane, solid}) {
                    EXPECT_TRUE(atMost(
                        "glass furnace", "|R + T - 1|, formula",
                        std::abs(double(shares.reflected.x) + shares.transmitted.x - 1.0), 1e-6))
                        << ior << " at " << degrees;
                }
            }
        }
    }
}

TEST(FormulaRows, Grazing) {
    for (const float eta : {1.0003f, 1.1f, 1.33f, 1.5f, 2.42f, 3.0f}) {
        double before = 0.0, slope = 0.0;
        for (int i = 0; i <= 999; ++i) {
            const double degrees = 80.0 + 0.01 * i;
            const double now = glsl::fresnelDielectric(float(std::cos(radians(degrees))), eta);
            const double exact = twin::fresnelDielectric(std::cos(radians(degrees)), eta);
            const double exactBefore =
                twin::fresnelDielectric(std::cos(radians(degrees - 0.01)), eta);
            if (i > 0) {
                // A decrease is at most float's rounding error of a value up to 1.
                EXPECT_TRUE(atMost("grazing", "step down of F", before - now, 2.4e-7)) << degrees;
                slope = std::max(slope, std::abs((now - before) - (exact - exactBefore)));
            }
            before = now;
        }
        EXPECT_TRUE(atMost("grazing", "step that the true F does not have", slope, 2e-5)) << eta;
        EXPECT_TRUE(atMost("grazing", "1 - F at 90 degrees",
                           1.0 - glsl::fresnelDielectric(0.0f, eta), 0.0));
    }
}

// Blur widths go with alpha = roughness^2, so the figure that grows evenly is their root.
TEST(FormulaRows, Roughness) {
    for (const float size : {64.0f, 256.0f, 1080.0f}) {
        const auto width = [&](float roughness) {  // of the lobe in texels, below 1: sharp
            return std::sqrt(std::exp2(glsl::environmentLod(roughness, size, 16.0f)));
        };
        const auto mirrored = [&](float roughness) {
            return std::sqrt(std::exp2(glsl::mirrorLod(roughness, size, 2.0f, 3.0f)));
        };
        EXPECT_EQ(glsl::environmentLod(0.0f, size, 16.0f), 0.0f);
        EXPECT_EQ(glsl::mirrorLod(0.0f, size, 2.0f, 3.0f), 0.0f);
        for (const auto& [name, of] :
             {std::pair<const char*, std::function<float(float)>>{"cube", width},
              {"mirror", mirrored}}) {
            const double mean = (of(1.0f) - of(0.0f)) / 100.0;
            for (int i = 1; i <= 100; ++i) {
                const double step = of(float(i) / 100.0f) - of(float(i - 1) / 100.0f);
                EXPECT_TRUE(atLeast("roughness", "step of the blur, formula", step, 0.0));
                EXPECT_TRUE(atMost("roughness", "step / mean step, formula", step / mean, 1.5))
                    << name << ' ' << i;
            }
        }
    }
}

TEST(FormulaRows, TransformsOfPlanes) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> exponent(-4.0, 4.0);
    for (int i = 0; i < steps(2000, 100000); ++i) {
        glm::dmat4 m(1.0);
        for (int c = 0; c < 3; ++c) {
            const double scale = std::pow(10.0, exponent(random)) * (i % 2 && c == 0 ? -1.0 : 1.0);
            for (int r = 0; r < 3; ++r) m[c][r] = scale * normal(random);
            m[3][c] = 10.0 * normal(random);
        }
        const dvec3 n = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
        const Plane plane{n, normal(random)};
        const auto moved = transformed(plane, m);
        if (!moved) continue;  // flattened to a line: refused
        const dvec3 across = glm::normalize(glm::cross(n, dvec3(0.3, 0.5, 0.8)));
        const dvec3 point = -plane.offset * n + 2.0 * across;
        const dvec3 there = m * glm::dvec4(point, 1.0);
        EXPECT_TRUE(atMost("transforms", "|n'.Mp + d'| / (|Mp| + |d'|)",
                           std::abs(glm::dot(moved->normal, there) + moved->offset) /
                               (glm::length(there) + std::abs(moved->offset)),
                           4e-6));
    }
}

TEST(FormulaRows, FieldOfView) {
    FrameRequest request;
    std::vector<double> taken, refused{0.0, 0.5, 0.999, 179.001, 180.0, 360.0, -45.0};
    for (int degrees = 1; degrees <= 179; ++degrees) taken.push_back(degrees);
    Range range{0, 0};
    fields(request.camera, [&](std::string_view name, auto&, const auto& kind, const char*) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, Range>) {
            if (name == "yfov") range = kind;
        }
    });
    const auto within = [&](double degrees) {
        const double angle = radians(degrees);
        return angle >= range.min && angle <= range.max;
    };
    for (const double degrees : taken) {
        EXPECT_TRUE(atMost("field of view", "angles 1..179 refused", !within(degrees), 0.0))
            << degrees;
    }
    for (const double degrees : refused) {
        EXPECT_TRUE(atMost("field of view", "angles outside taken", within(degrees), 0.0))
            << degrees;
    }
}

}  // namespace
}  // namespace clerestory::test
