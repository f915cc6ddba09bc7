// Paths that share a rough lobe, compared with integrals over it that are computed here.
#include "ray_room.h"
#include "rays/path.h"

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

using namespace clerestory;
using namespace clerestory::rays;

namespace {

constexpr std::uint32_t kPatterns = 16;

// A bright half-plane at a height of one metre, where x is above 0.3, under a map of one colour.
class Room : public RayRoom {
public:
    Room(bool bright, float map) : RayRoom(map) {
        materialRow(5).w = float(TRACE_UNLIT | TRACE_DOUBLE_SIDED);
        if (bright) add({0.3f, -1e4f, 1.0f}, {0.3f, 1e4f, 1.0f}, {1e4f, 0.0f, 1.0f});
    }
    Path follow(const RecordedRay& ray, Ray kind, const glm::vec3& eye, const Lobe& lobe) const {
        const Surroundings around = surroundings(eye);
        return PathTracer(around).follow(ray, kind, lobe);
    }
    std::vector<Path> followAll(std::span<const RayWithLobe> rays, Ray kind) const {
        const Surroundings around = surroundings(glm::vec3(0.0f, 0.0f, 5.0f));
        std::vector<Path> paths(rays.size());
        PathTracer(around).follow(rays, kind, paths);
        return paths;
    }
};

// At the origin, with the normal +Z.
RecordedRay mirrored(const glm::vec3& toEye, float roughness) {
    return {.start = glm::vec3(0.0f),
            .along = {-toEye.x, -toEye.y, toEye.z},
            .share = glm::vec3(1.0f),
            .width = 1e-4f,
            .pixel = 1e-3f,
            .lobe = 2.0f * roughness * roughness,
            .intoBody = false};
}

glm::vec3 towardsEye(float degrees, float turn) {
    const float angle = glm::radians(degrees);
    return {std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle)};
}

TEST(RayLobe, AUniformEnvironmentStaysAsItIs) {
    const Room room(false, 0.75f);
    for (const Ray kind : {Ray::mirrored, Ray::transmitted}) {
        for (const float roughness : {0.0f, 0.05f, 0.12f, 0.3f, 0.5f, 1.0f}) {
            for (const float degrees : {1.0f, 30.0f, 60.0f, 85.0f, 89.5f}) {
                for (const std::uint32_t paths : {1u, 3u, 4u, 16u}) {
                    const glm::vec3 eye = towardsEye(degrees, 0.7f);
                    const Path path =
                        room.follow(mirrored(eye, roughness), kind, 5.0f * eye, {paths, 9});
                    for (const float c : path.radiance) {
                        ASSERT_NEAR(c, 0.75f, 2e-6f) << roughness << " " << degrees << " " << paths;
                    }
                    ASSERT_LE(path.count, paths);
                    ASSERT_GE(path.count, 1u);
                }
            }
        }
    }
}

TEST(RayLobe, SmoothMirrorsHaveOnePath) {
    const Room room(true, 0.0f);
    const glm::vec3 eye = towardsEye(40.0f, 3.1f);
    const Path one = room.follow(mirrored(eye, 0.05f), Ray::mirrored, 5.0f * eye, {1, 0});
    const Path several = room.follow(mirrored(eye, 0.05f), Ray::mirrored, 5.0f * eye, {16, 5});
    EXPECT_EQ(several.count, 1u);
    EXPECT_EQ(several.radiance[0], one.radiance[0]);
    EXPECT_GT(room.follow(mirrored(eye, 0.2f), Ray::mirrored, 5.0f * eye, {16, 5}).count, 4u);
}

// Share of the half-plane in what a white rough mirror reflects: by summation over the hemisphere,
// with the formulae as Walter (2007) and Heitz (2014) print them.
double expectedShare(const glm::dvec3& v, double alpha) {
    const double a2 = alpha * alpha;
    const auto lambda = [&](double cosine) {
        const double tan2 = 1.0 / (cosine * cosine) - 1.0;
        return 0.5 * (std::sqrt(1.0 + a2 * tan2) - 1.0);
    };
    double hit = 0.0, all = 0.0;
    constexpr int kHeights = 1200, kTurns = 1200;
    for (int i = 0; i < kHeights; ++i) {
        const double z = (i + 0.5) / kHeights, sine = std::sqrt(1.0 - z * z);
        for (int j = 0; j < kTurns; ++j) {
            const double turn = 2.0 * std::numbers::pi * (j + 0.5) / kTurns;
            const glm::dvec3 l(sine * std::cos(turn), sine * std::sin(turn), z);
            const glm::dvec3 h = glm::normalize(l + v);
            const double d = h.z * h.z * (a2 - 1.0) + 1.0;
            const double weight =
                a2 / (std::numbers::pi * d * d) / (1.0 + lambda(v.z) + lambda(l.z)) / (4.0 * v.z);
            all += weight;
            if (l.x / l.z > 0.3) hit += weight;
        }
    }
    return hit / all;
}

TEST(RayLobe, MeanOfAMirrorIsThatOfItsLobe) {
    const Room room(true, 0.0f);
    for (const float roughness : {0.2f, 0.35f, 0.5f}) {
        for (const float degrees : {5.0f, 25.0f, 50.0f, 70.0f}) {
            const glm::vec3 eye = towardsEye(degrees, 3.4f);
            const double expected = expectedShare(eye, roughness * roughness);
            double mean = 0.0;
            for (std::uint32_t pattern = 0; pattern < kPatterns; ++pattern) {
                const Path path =
                    room.follow(mirrored(eye, roughness), Ray::mirrored, 5.0f * eye, {4, pattern});
                mean += path.radiance[0] / kPatterns;
            }
            EXPECT_NEAR(mean, expected, 0.03) << roughness << " " << degrees;
        }
    }
}

// Both faces of a pane scatter on their own: slopes are the sum of two.
TEST(RayLobe, MeanOfAPaneIsThatOfTwoFaces) {
    const Room room(true, 0.0f);
    const glm::vec3 eye = towardsEye(180.0f - 20.0f, 3.0f);  // below the pane
    for (const float lobe : {0.1f, 0.3f}) {
        const RecordedRay ray{.start = glm::vec3(0.0f),
                              .along = -eye,
                              .share = glm::vec3(1.0f),
                              .width = 1e-4f,
                              .pixel = 1e-3f,
                              .lobe = lobe,
                              .intoBody = false};
        // A projection of GGX's slopes has the distribution function (1 + x / sqrt(a^2 + x^2)) / 2;
        // here its sum with itself, by summation over one of both.
        const double a = lobe / std::sqrt(3.0);
        const glm::dvec3 plane = glm::normalize(glm::dvec3(1.0, 0.0, -0.3));  // through the edge
        const double inclination = -glm::dot(glm::dvec3(eye), plane);
        const double edge = inclination / std::sqrt(1.0 - inclination * inclination);
        double expected = 0.0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double p = 2.0 * (i + 0.5) / kSteps - 1.0;
            const double x = edge + a * p / std::sqrt(1.0 - p * p);
            expected += 0.5 * (1.0 + x / std::hypot(a, x)) / kSteps;
        }
        double mean = 0.0;
        for (std::uint32_t pattern = 0; pattern < kPatterns; ++pattern) {
            const Path path = room.follow(ray, Ray::transmitted, 5.0f * eye, {16, pattern});
            mean += path.radiance[0] / kPatterns;
        }
        EXPECT_NEAR(mean, expected, 0.03) << lobe;
    }
}

TEST(RayLobe, RecordsSayWhetherARayEntersABody) {
    const Start start{.position = {1.0f, 2.0f, 3.0f}, .cone = glm::packHalf2x16({0.5f, -3.0f})};
    for (const float sign : {1.0f, -1.0f}) {
        const Way way{.octahedral = {0.0f, 0.0f},
                      .shareRedGreen = glm::packHalf2x16({0.5f, 0.25f}),
                      .shareBlueLobe = glm::packHalf2x16({0.125f, sign * 0.375f})};
        const RecordedRay ray = rayOf(start, way);
        EXPECT_EQ(ray.lobe, 0.375f);
        EXPECT_EQ(ray.intoBody, sign < 0.0f);
        EXPECT_EQ(ray.width, 0.125f);
        EXPECT_EQ(ray.along, glm::vec3(0.0f, 0.0f, 1.0f));
    }
}

// Lobes of several paths and single rays, more than are traced at once.
TEST(RayLobe, PathsThatAreFollowedTogetherAreThoseFollowedAlone) {
    const Room room(true, 0.25f);
    std::vector<RayWithLobe> rays;
    for (std::uint32_t i = 0; i < 90; ++i) {
        const glm::vec3 eye = towardsEye(static_cast<float>(i % 89), 0.07f * static_cast<float>(i));
        rays.push_back({mirrored(eye, 0.01f * static_cast<float>(i % 60)), {1 + i % 16, i % 16}});
    }
    // Of these most directions are below the surface, and a ray may have none.
    for (std::uint32_t i = 0; i < 200; ++i) {
        rays.push_back(
            {mirrored(towardsEye(89.99f, 0.1f * static_cast<float>(i)), 1.0f), {2, i % 16}});
    }
    for (const Ray kind : {Ray::mirrored, Ray::transmitted}) {
        const std::vector<Path> together = room.followAll(rays, kind);
        std::size_t bright = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Path alone = room.followAll(std::span(rays).subspan(i, 1), kind).front();
            for (int c = 0; c < 3; ++c) ASSERT_EQ(together[i].radiance[c], alone.radiance[c]) << i;
            ASSERT_EQ(together[i].surfaces, alone.surfaces) << i;
            ASSERT_EQ(together[i].distance, alone.distance) << i;
            ASSERT_EQ(together[i].count, alone.count) << i;
            bright += alone.radiance[0] > 0.3f ? 1 : 0;
        }
        EXPECT_GT(bright, 10u);
        EXPECT_LT(bright, rays.size() - 10);
    }
}

}  // namespace
