// The chapel has no holes and no visible back faces: rays against its triangles.
#include "scene/builtin/builtin_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace clerestory::test {
namespace {

// The first hit of a ray, by Moeller and Trumbore 1997; the instances of the chapel's shell are not
// transformed.
struct Hit {
    float distance = std::numeric_limits<float>::infinity();
    bool front = false;
    std::string mesh;
};

Hit firstHit(const Scene& scene, const glm::vec3& origin, const glm::vec3& direction) {
    Hit hit;
    const Pose pose = poseAt(scene, 0.0);
    for (const Instance& instance : scene.instances) {
        if (pose.worldFromNode[instance.node] != glm::dmat4(1.0)) continue;
        const Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            const glm::vec3 a = (cluster.bounds.min - 0.01f - origin) / direction,
                            b = (cluster.bounds.max + 0.01f - origin) / direction;
            const glm::vec3 near = glm::min(a, b), far = glm::max(a, b);
            if (std::max({near.x, near.y, near.z, 0.0f}) > std::min({far.x, far.y, far.z}))
                continue;
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                const auto corner = [&](std::uint32_t k) {
                    return scene.vertices[scene.indices[cluster.firstIndex + i + k]].position;
                };
                const glm::vec3 p = corner(0), e1 = corner(1) - p, e2 = corner(2) - p;
                const glm::vec3 q = glm::cross(direction, e2), r = glm::cross(origin - p, e1);
                const float determinant = glm::dot(e1, q);
                if (determinant == 0.0f) continue;
                const float u = glm::dot(origin - p, q) / determinant,
                            v = glm::dot(direction, r) / determinant,
                            t = glm::dot(e2, r) / determinant;
                if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t > 0.0f && t < hit.distance)
                    hit = {t, determinant > 0.0f, mesh.name};
            }
        }
    }
    return hit;
}

// Directions all round, none of them along a plane of the axes.
glm::vec3 spiralDirection(int i, int count) {
    const float y = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / static_cast<float>(count);
    const float a = 2.399963f * static_cast<float>(i) + 0.1f, r = std::sqrt(1.0f - y * y);
    return {r * std::cos(a), y, r * std::sin(a)};
}

TEST(Chapel, OnlyFrontFacesAreVisible) {
    const Scene scene = chapel();
    // In the nave, and in the aisle that has no door.
    for (const glm::vec3 eye : {glm::vec3(0.13f, 3.1f, 0.21f), glm::vec3(-5.3f, 1.7f, 5.1f)}) {
        for (int i = 0; i < 600; ++i) {
            const glm::vec3 direction = spiralDirection(i, 600);
            const Hit hit = firstHit(scene, eye, direction);
            ASSERT_TRUE(std::isfinite(hit.distance) ||
                        eye.x + 20.0f * direction.x > 6.6f)  // out of the door
                << "a hole towards " << direction.x << " " << direction.y << " " << direction.z;
            EXPECT_TRUE(hit.front || !std::isfinite(hit.distance))
                << hit.mesh << " shows its back towards " << direction.x << " " << direction.y
                << " " << direction.z;
        }
    }
}

TEST(Chapel, EndWallsCloseTheVaults) {
    const Scene scene = chapel();
    struct Vault {
        float center, half, spring, radius;
    };
    for (const Vault& vault : {Vault{0.0f, 3.3f, 10.4f, 5.0f}, Vault{5.25f, 1.35f, 6.7f, 1.75f},
                               Vault{-5.25f, 1.35f, 6.7f, 1.75f}}) {
        for (const float end : {-12.0f, 12.0f}) {
            for (int i = 1; i < 100; ++i) {
                const float x = vault.half * (0.02f * static_cast<float>(i) - 1.0f);
                const float reach = std::abs(x) + vault.radius - vault.half;
                const float rise = std::sqrt(vault.radius * vault.radius - reach * reach);
                const glm::vec3 eye(vault.center + 0.01f, 5.9f, 0.5f * end);
                for (const float under : {0.002f, 0.01f, 0.03f}) {
                    const glm::vec3 edge(vault.center + x, vault.spring + rise - under, end);
                    ASSERT_TRUE(std::isfinite(firstHit(scene, eye, edge - eye).distance))
                        << "x " << x << " of the vault at " << vault.center;
                }
            }
        }
    }
}

}  // namespace
}  // namespace clerestory::test
