// Scenes and rays for tests of the hierarchy, and its invariants: it finds what a linear search in
// double over the scene's triangles finds, and it is a tree.
#pragma once

#include "scene/bvh.h"
#include "scene/mesh_builder.h"

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace clerestory::test {

inline constexpr float kFar = std::numeric_limits<float>::max();

struct Triangle {
    glm::dvec3 a, e1, e2;
};

// From the scene, not from the hierarchy; relative to the origin of the rays.
inline std::vector<Triangle> trianglesOf(const Scene& scene, const glm::dvec3& origin) {
    const Pose pose = poseAt(scene, 0.0);
    std::vector<Triangle> result;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                const auto corner = [&](std::uint32_t k) {
                    const std::uint32_t vertex = scene.indices[cluster.firstIndex + i + k];
                    return glm::dvec3(pose.worldFromNode[instance.node] *
                                      glm::dvec4(scene.vertices[vertex].position, 1.0)) -
                           origin;
                };
                result.push_back({corner(0), corner(1) - corner(0), corner(2) - corner(0)});
            }
        }
    }
    return result;
}

struct ExpectedHit {
    double distance = std::numeric_limits<double>::infinity();
    double sine = 1.0;    // of the angle between ray and plane
    double inside = 0.0;  // the least of the three weights
};

inline ExpectedHit crossing(const Triangle& t, const glm::dvec3& o, const glm::dvec3& d) {
    const glm::dvec3 n = glm::cross(t.e1, t.e2), s = o - t.a, r = glm::cross(s, d);
    const double facing = -glm::dot(n, d);
    if (facing == 0.0) return {};
    const double u = glm::dot(t.e2, r) / facing, v = -glm::dot(t.e1, r) / facing;
    return {glm::dot(n, s) / facing, std::abs(facing) / (glm::length(n) * glm::length(d)),
            std::min({u, v, 1.0 - u - v})};
}

struct Ray {
    glm::vec3 origin, direction;
};

// Both ways round: what the loop surely meets, the walk meets no later; and what the walk meets is
// there. `reach` is the size of the scene, metres. Returns the number of hits.
inline int expectSame(const Bvh& bvh, const std::vector<Triangle>& triangles,
                      const std::vector<Ray>& rays, double reach) {
    int hits = 0;
    for (const Ray& ray : rays) {
        const glm::dvec3 o(ray.origin), d(ray.direction);
        const double length = glm::length(d);
        double surely = std::numeric_limits<double>::infinity(), sine = 1.0;
        for (const Triangle& t : triangles) {
            const ExpectedHit c = crossing(t, o, d);
            if (c.inside > 1e-4 && c.sine > 1e-3 && c.distance * length > 1e-5 * reach &&
                c.distance < surely) {
                surely = c.distance;
                sine = c.sine;
            }
        }
        const auto hit = nearestHit(bvh, ray.origin, ray.direction, 0.0f, kFar);
        if (!hit) {
            EXPECT_FALSE(std::isfinite(surely)) << "lost at " << surely;
            continue;
        }
        ++hits;
        EXPECT_LE(hit->distance * length, surely * length + 1e-5 * reach / sine);
        // The point the weights name lies on the ray, at the distance.
        const auto found =
            std::find_if(bvh.triangles.begin(), bvh.triangles.end(), [&](const BvhTriangle& t) {
                return t.triangle == static_cast<float>(hit->triangle) &&
                       t.instance == static_cast<float>(hit->instance);
            });
        EXPECT_NE(found, bvh.triangles.end());
        if (found == bvh.triangles.end()) continue;
        EXPECT_TRUE(hit->u >= 0.0f && hit->v >= 0.0f && hit->u + hit->v <= 1.000001f);
        const glm::dvec3 e1(found->b - found->a), e2(found->c - found->a), n = glm::cross(e1, e2);
        const double grazing = std::max(1e-4, std::abs(glm::dot(n, d)) / (glm::length(n) * length));
        const glm::dvec3 point = glm::dvec3(found->a) + double{hit->u} * e1 + double{hit->v} * e2;
        EXPECT_LT(glm::distance(point, o + double{hit->distance} * d),
                  1e-5 * (reach + glm::length(o)) / grazing);
    }
    return hits;
}

inline MeshDraft soup(std::mt19937& random, int count, double size) {
    std::uniform_real_distribution<double> at(-1.0, 1.0);
    const auto point = [&] { return glm::dvec3(at(random), at(random), at(random)); };
    MeshDraft draft{.name = "soup"};
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 middle = point();
        for (int k = 0; k < 3; ++k) {
            Vertex v;
            v.position = glm::vec3(middle + size * point());
            draft.indices.push_back(static_cast<std::uint32_t>(draft.vertices.size()));
            draft.vertices.push_back(v);
        }
    }
    return draft;
}

// A closed ball of radius 1 whose triangles share their vertices, poles and seam too.
inline MeshDraft ball(int rows, int columns) {
    MeshDraft draft{.name = "ball"};
    const auto add = [&](double theta, double phi) {
        Vertex v;
        v.position = glm::vec3(std::sin(theta) * std::cos(phi), std::cos(theta),
                               std::sin(theta) * std::sin(phi));
        draft.vertices.push_back(v);
    };
    add(0.0, 0.0);
    for (int j = 1; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            add(3.14159265358979 * j / rows, 6.28318530717959 * i / columns);
    add(3.14159265358979, 0.0);
    const auto at = [&](int j, int i) {
        const int number = j == 0      ? 0
                           : j == rows ? (rows - 1) * columns + 1
                                       : 1 + (j - 1) * columns + i % columns;
        return static_cast<std::uint32_t>(number);
    };
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            if (j > 0)
                for (const std::uint32_t k : {at(j, i), at(j, i + 1), at(j + 1, i)})
                    draft.indices.push_back(k);
            if (j + 1 < rows)
                for (const std::uint32_t k : {at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)})
                    draft.indices.push_back(k);
        }
    }
    return draft;
}

inline Scene sceneOf(MeshDraft draft, const std::vector<glm::dmat4>& places = {glm::dmat4(1.0)}) {
    Scene scene;
    scene.materials.push_back({.doubleSided = true});
    const Index mesh = addMesh(scene, std::move(draft));
    for (const glm::dmat4& place : places) addInstance(scene, addNode(scene, "at", place), mesh);
    return scene;
}

inline Bvh bvhOf(const Scene& scene) {
    return buildBvh(scene, poseAt(scene, 0.0));
}

inline glm::dvec3 unit(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

// From around and from inside a region, some along the axes and some in faces of boxes.
inline std::vector<Ray> raysThrough(std::mt19937& random, const Bvh& bvh, double size, int count) {
    std::uniform_real_distribution<double> at(-1.0, 1.0);
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i) {
        glm::vec3 origin(
            size * (i % 2 ? 3.0 * unit(random) : glm::dvec3(at(random), at(random), at(random))));
        glm::vec3 direction(unit(random));
        if (i % 2 == 1) {
            const glm::dvec3 target = 0.7 * size * glm::dvec3(at(random), at(random), at(random));
            direction = glm::vec3(glm::normalize(target - glm::dvec3(origin)));
        }
        if (i % 5 == 0) {
            const int axis = i / 5 % 3;
            direction = glm::vec3(0.0f);
            direction[axis] = i % 2 ? 1.0f : -1.0f;
            if (i % 4 == 0) {
                const auto node = static_cast<std::size_t>(i) % bvh.nodes.size();
                origin[(axis + 1) % 3] = bvh.nodes[node].low[(axis + 1) % 3];
            }
        }
        rays.push_back({origin, direction});
    }
    return rays;
}

inline void expectSound(const Bvh& bvh) {
    const std::size_t count = bvh.nodes.size();
    std::vector<int> held(bvh.triangles.size(), 0);
    std::vector<std::size_t> open;  // the branches that the node stands in
    for (std::size_t i = 0; i < count; ++i) {
        const BvhNode& node = bvh.nodes[i];
        const auto skip = static_cast<std::size_t>(node.skip);
        ASSERT_GT(skip, i);
        ASSERT_LE(skip, count);
        while (!open.empty() && static_cast<std::size_t>(bvh.nodes[open.back()].skip) <= i)
            open.pop_back();
        ASSERT_EQ(open.empty(), i == 0) << "more than one root";
        ASSERT_LT(open.size(), 100u) << "too deep";
        if (!open.empty()) {
            const BvhNode& parent = bvh.nodes[open.back()];
            EXPECT_LE(skip, static_cast<std::size_t>(parent.skip));
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(node.low, parent.low)));
            EXPECT_TRUE(glm::all(glm::lessThanEqual(node.high, parent.high)));
        }
        if (node.leaf < 0.0f) {
            EXPECT_GE(skip, i + 3) << "an inner node has two children";
            open.push_back(i);
            continue;
        }
        EXPECT_EQ(skip, i + 1);
        const auto leaf = static_cast<std::size_t>(node.leaf);
        ASSERT_TRUE(leaf % 8 >= 1 && leaf / 8 + leaf % 8 <= held.size());
        for (std::size_t k = leaf / 8; k < leaf / 8 + leaf % 8; ++k) {
            ++held[k];
            const BvhTriangle& t = bvh.triangles[k];
            for (const glm::vec3& p : {t.a, t.b, t.c}) {
                EXPECT_TRUE(glm::all(glm::lessThanEqual(node.low, p)));
                EXPECT_TRUE(glm::all(glm::greaterThanEqual(node.high, p)));
            }
        }
    }
    if (count > 0) {
        EXPECT_EQ(static_cast<std::size_t>(bvh.nodes[0].skip), count);
    }
    EXPECT_EQ(std::count(held.begin(), held.end(), 1), std::ssize(held));
}

}  // namespace clerestory::test
