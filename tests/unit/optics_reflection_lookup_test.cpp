// Lookups of reflections: levels compared with the cone formula, parallax compared with rooms.
#include "optics_support.h"

#include <gtest/gtest.h>
#include <random>

namespace clerestory::test {
namespace {

using glm::dvec3;
using glm::vec3;

// ---- blur (R4) ---------------------------------------------------------------------------------

TEST(MirrorLod, FollowsTheConeFormula) {
    for (const double roughness : {0.1, 0.3, 0.7, 1.0}) {
        for (const double beyond : {0.01, 0.5, 3.0, 100.0}) {
            const double toMirror = 2.0, focal = 620.0, alpha = roughness * roughness;
            const double level =
                std::log2(2.0 * std::sqrt(6.0) * alpha * focal * beyond / (toMirror + beyond));
            EXPECT_NEAR(glsl::mirrorLod(float(roughness), 620.0f, 2.0f, float(beyond)),
                        std::max(0.0, level), 1e-5);
        }
    }
}

TEST(MirrorLod, ContactAndSmoothMirrorsAreSharp) {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        EXPECT_EQ(glsl::mirrorLod(roughness, 1000.0f, 1.0f, 0.0f), 0.0f);
    }
    for (const float beyond : {0.0f, 1.0f, 1e30f, kInf, kNaN}) {
        EXPECT_EQ(glsl::mirrorLod(0.0f, 1000.0f, 1.0f, beyond), 0.0f);
    }
}

TEST(MirrorLod, FiniteForEveryInput) {
    const std::vector<float> hard{-kInf, -1.0f, 0.0f, 1e-38f, 1e-7f, 1.0f, 1e9f, 3e38f, kInf, kNaN};
    for (const float roughness : hard) {
        for (const float focal : hard) {
            for (const float near : hard) {
                for (const float far : hard) {
                    const float lod = glsl::mirrorLod(roughness, focal, near, far);
                    ASSERT_TRUE(lod >= 0.0f && lod < 64.0f);
                }
            }
        }
    }
}

TEST(MirrorLod, IsMonotonicInRoughnessAndDistance) {
    float before = 0.0f, beforeFar = 0.0f;
    for (int i = 0; i <= 100; ++i) {
        const float lod = glsl::mirrorLod(0.01f * float(i), 600.0f, 1.0f, 5.0f);
        EXPECT_GE(lod, before);
        before = lod;
        const float far = glsl::mirrorLod(0.4f, 600.0f, 1.0f, 0.05f * float(i));
        EXPECT_GE(far, beforeFar);
        beforeFar = far;
    }
    // Twice the pixels, one level more.
    EXPECT_NEAR(glsl::mirrorLod(0.5f, 1200.0f, 1, 5) - glsl::mirrorLod(0.5f, 600.0f, 1, 5), 1.0f,
                1e-5f);
}

// A cube's face has half its edge as pixels per slope, and its surroundings are far away.
TEST(MirrorLod, OfDistantObjectsIsTheCubesLevel) {
    for (const float roughness : {0.1f, 0.2f, 0.5f, 0.8f}) {
        EXPECT_NEAR(glsl::mirrorLod(roughness, 128.0f, 1.0f, kInf),
                    glsl::environmentLod(roughness, 256.0f, 99.0f), 2e-5f)
            << roughness;
    }
}

// ---- parallax (C2) -----------------------------------------------------------------------------

double angle(const dvec3& a, const dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// A point on a wall of the room, seen from the probe and by the reflected ray from another
// position.
TEST(BoxParallax, IsExactInABoxRoom) {
    const dvec3 low(-1.0, -0.4, -3.0), high(2.0, 1.5, 0.7);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 50000; ++i) {
        const dvec3 from = glm::mix(low, high, dvec3(unit(random), unit(random), unit(random)));
        dvec3 wall = glm::mix(low, high, dvec3(unit(random), unit(random), unit(random)));
        wall[i % 3] = i % 2 ? low[i % 3] : high[i % 3];
        const dvec3 ray = glm::normalize(wall - from);
        // Too near or along the wall: the rounding of the ray itself is seen there.
        if (glm::length(wall - from) < 0.02 || std::abs(ray[i % 3]) < 0.05) continue;
        const vec3 seen = glsl::boxParallax(vec3(from), vec3(ray), vec3(low), vec3(high));
        ASSERT_LT(angle(dvec3(seen), wall), 1e-5) << i;
    }
}

TEST(BoxParallax, AlongTheAxesAndOnTheWalls) {
    const vec3 low(-1.0f), high(1.0f);
    for (int axis = 0; axis < 3; ++axis) {
        vec3 along(0.0f), at(0.3f);
        along[axis] = 1.0f;
        vec3 wall = at;
        wall[axis] = 1.0f;
        EXPECT_NEAR(glm::distance(glsl::boxParallax(at, along, low, high), glm::normalize(wall)),
                    0.0f, 1e-6f);
        // The mirror is the wall, and rounding put it a little outside.
        vec3 onWall = at;
        onWall[axis] = -1.0005f;
        EXPECT_NEAR(
            glm::distance(glsl::boxParallax(onWall, along, low, high), glm::normalize(wall)), 0.0f,
            1e-6f);
    }
}

TEST(Parallax, OutsideTheProxyDirectionsAreUnchanged) {
    const vec3 direction = glm::normalize(vec3(1.0f, 2.0f, -3.0f));
    for (const vec3& p : {vec3(1.5f, 0, 0), vec3(0, -9, 0), vec3(0, 0, 1e30f), vec3(kNaN, 0, 0)}) {
        EXPECT_EQ(glsl::boxParallax(p, direction, vec3(-1.0f), vec3(1.0f)), direction);
        EXPECT_EQ(glsl::sphereParallax(p, direction, vec3(0.0f), 1.0f), direction);
    }
}

TEST(Parallax, AtTheProbeDirectionsAreUnchanged) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 1000; ++i) {
        const vec3 d = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        EXPECT_NEAR(glm::distance(glsl::boxParallax(vec3(0.0f), d, vec3(-2), vec3(1, 3, 5)), d),
                    0.0f, 1e-6f);
        EXPECT_NEAR(glm::distance(glsl::sphereParallax(vec3(0.0f), d, vec3(0.0f), 7.0f), d), 0.0f,
                    1e-6f);
    }
}

TEST(SphereParallax, IsExactInARoundRoom) {
    const dvec3 center(0.4, -0.2, 0.1);
    const double radius = 3.0;
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0.0, 0.999);
    const auto anywhere = [&] {
        return glm::normalize(dvec3(normal(random), normal(random), normal(random)));
    };
    for (int i = 0; i < 50000; ++i) {
        const dvec3 from = center + unit(random) * radius * anywhere();
        const dvec3 wall = center + radius * anywhere();
        if (glm::length(wall - from) < 0.02) continue;
        const vec3 seen = glsl::sphereParallax(vec3(from), vec3(glm::normalize(wall - from)),
                                               vec3(center), float(radius));
        ASSERT_LT(angle(dvec3(seen), wall), 1e-5) << i;
    }
}

TEST(Parallax, UnitAndFiniteForExtremeRays) {
    for (const float x : hardCosines()) {
        for (const float y : hardCosines()) {
            vec3 d(x, y, 0.3f);
            d = glm::normalize(d);
            for (const float size : {1e-30f, 1e-3f, 1.0f, 1e6f}) {
                for (const float at : {0.0f, 0.5f, 1.0f}) {
                    const vec3 p(at * size);
                    const vec3 box = glsl::boxParallax(p, d, vec3(-size), vec3(size));
                    const vec3 ball = glsl::sphereParallax(p, d, vec3(0.0f), size);
                    ASSERT_NEAR(glm::length(box), 1.0f, 1e-5f) << x << ' ' << y << ' ' << size;
                    ASSERT_NEAR(glm::length(ball), 1.0f, 1e-5f) << x << ' ' << y << ' ' << size;
                }
            }
        }
    }
}

// Against the lobe's integrals over Legendre's polynomials, relative to those of a cosine.
TEST(LobeBands, AreTheIntegralsOfTheLobe) {
    for (double roughness = 0.7; roughness <= 1.0; roughness += 0.025) {
        const double a2 = std::pow(roughness, 4.0);
        double weights = 0.0, linear = 0.0, quadratic = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const double c = (i + 0.5) / 20000.0, q = 0.5 * (1.0 + c) * (a2 - 1.0) + 1.0;
            const double weight = a2 / (q * q) * c;
            weights += weight;
            linear += weight * c;
            quadratic += weight * (1.5 * c * c - 0.5);
        }
        const glm::vec2 bands = glsl::lobeBands(float(roughness));
        EXPECT_NEAR(bands.x, linear / weights * 1.5, 3e-3) << roughness;
        EXPECT_NEAR(bands.y, quadratic / weights * 4.0, 1e-2) << roughness;
    }
}

}  // namespace
}  // namespace clerestory::test
