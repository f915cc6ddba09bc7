// Embree's hits compared with those of the shaders' hierarchy, and a cube map in main memory.
#include "rays/cube_map.h"
#include "rays/triangle_tree.h"
#include "scene/builtin/builtin_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace clerestory;

namespace {

glm::vec3 anyDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return glm::normalize(glm::vec3(normal(random), normal(random), normal(random) + 1e-3f));
}

// An edge that two triangles share belongs to either, so distances are compared.
TEST(TriangleTree, HasTheHitsOfTheShadersHierarchy) {
    for (const char* id : {"chapel", "teapots", "meadow"}) {
        const Scene scene = *makeBuiltinScene(id);
        const Pose pose = poseAt(scene, 1.0);
        const Bvh bvh = buildBvh(scene, pose);
        rays::TriangleTree tree;
        BvhTriangles still = stillTriangles(scene, pose);
        EXPECT_EQ(still.origin, bvh.origin) << id;
        tree.setStill(std::move(still.triangles));
        tree.setMoving(movingTriangles(scene, pose, {}, tree.stillTriangles()).triangles);
        std::mt19937 random(11);
        std::uniform_real_distribution<float> unit(-0.5f, 0.5f);
        const glm::vec3 extent = lastingBounds(scene, pose).extent();
        int hits = 0, different = 0;
        constexpr int kRays = 20'000;
        for (int i = 0; i < kRays; ++i) {
            const glm::vec3 origin = extent * glm::vec3(unit(random), unit(random), unit(random));
            const glm::vec3 direction = anyDirection(random);
            const auto expected = nearestHit(bvh, origin, direction, 0.0f, 1e30f);
            rays::TriangleHit hit;
            const bool met = tree.nearestHit(&origin.x, &direction.x, hit);
            if (!expected && !met) continue;
            ++hits;
            const float distance = expected ? expected->distance : 0.0f;
            if (!expected || !met ||
                std::abs(hit.distance - distance) > 1e-4f * (1.0f + distance)) {
                ++different;
                continue;
            }
            const glm::vec3 normal =
                glm::cross(tree.triangle(hit.triangle).b - tree.triangle(hit.triangle).a,
                           tree.triangle(hit.triangle).c - tree.triangle(hit.triangle).a);
            EXPECT_LE(tree.triangle(hit.triangle).side * glm::dot(normal, direction), 0.0f) << id;
        }
        EXPECT_GT(hits, kRays / 10) << id;
        EXPECT_LE(different, hits / 2000) << id;
    }
}

TEST(TriangleTree, RejectsWhatIsNoRay) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    rays::TriangleTree tree;
    rays::TriangleHit hit;
    const float origin[3] = {0.0f, 0.0f, 0.0f}, along[3] = {0.0f, 0.0f, -1.0f};
    EXPECT_FALSE(tree.nearestHit(origin, along, hit)) << "an empty tree";
    tree.setStill({{{-1, -1, -2}, 0.0f, {1, -1, -2}, 0.0f, {0, 1, -2}, 0.0f}});
    EXPECT_TRUE(tree.nearestHit(origin, along, hit));
    EXPECT_FLOAT_EQ(hit.distance, 2.0f);
    const float invalid[3] = {nan, 0.0f, 0.0f};
    EXPECT_FALSE(tree.nearestHit(invalid, along, hit));
    EXPECT_FALSE(tree.nearestHit(origin, invalid, hit));
}

TEST(CubeMap, IsContinuousAcrossEdgesAndExactAtTexels) {
    rays::CubeMap map(8, 3);
    // Each texel holds its own direction.
    for (std::uint32_t level = 0; level < 3; ++level) {
        const int size = 8 >> level;
        for (std::uint32_t face = 0; face < 6; ++face) {
            std::vector<float> texels;
            for (int y = 0; y < size; ++y) {
                for (int x = 0; x < size; ++x) {
                    const float s = (2.0f * float(x) + 1.0f) / float(size) - 1.0f;
                    const float t = (2.0f * float(y) + 1.0f) / float(size) - 1.0f;
                    const glm::vec3 d[6] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                            {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
                    const glm::vec3 unit = glm::normalize(d[face]);
                    texels.insert(texels.end(), {unit.x, unit.y, unit.z, 1.0f});
                }
            }
            map.setFace(level, face, texels);
        }
    }
    map.joinEdges();
    std::mt19937 random(3);
    for (int i = 0; i < 5000; ++i) {
        const glm::vec3 direction = anyDirection(random);
        glm::vec3 value, nearby;
        map.sample(&direction.x, 0.0f, &value.x);
        EXPECT_LT(glm::length(value - direction), 0.12f);
        const glm::vec3 other = direction + 1e-4f * anyDirection(random);
        map.sample(&other.x, 0.0f, &nearby.x);
        EXPECT_LT(glm::length(value - nearby), 2e-3f) << "no step, not at an edge either";
    }
    const glm::vec3 center(1.0f, 0.125f, 0.125f);  // of a texel of +X
    glm::vec3 value;
    map.sample(&center.x, 0.0f, &value.x);
    EXPECT_LT(glm::length(value - glm::normalize(center)), 1e-5f);
    map.sample(&center.x, 99.0f, &value.x);  // levels are clamped
    EXPECT_TRUE(std::isfinite(value.x));
}

}  // namespace
