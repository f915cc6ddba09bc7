// Rays through the hierarchy compared with a linear search over every triangle in double.
#include "scene/bvh.h"
#include "scene/builtin/builtin_scenes.h"
#include "scene/mesh_builder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

using namespace clerestory;

namespace {

struct Ray {
    glm::vec3 origin, direction;
};

// Moeller and Trumbore 1997; the first of equally near triangles.
std::optional<double> plainDistance(const Bvh& bvh, const Ray& ray) {
    double nearest = std::numeric_limits<double>::infinity();
    const glm::dvec3 o(ray.origin), d(ray.direction);
    for (const BvhTriangle& t : bvh.triangles) {
        const glm::dvec3 a(t.a), e1 = glm::dvec3(t.b) - a, e2 = glm::dvec3(t.c) - a;
        const glm::dvec3 p = glm::cross(d, e2);
        const double det = glm::dot(e1, p);  // above 0: seen from the front
        if (det == 0.0 || det * double{t.side} < 0.0) continue;
        const double u = glm::dot(o - a, p) / det;
        const glm::dvec3 q = glm::cross(o - a, e1);
        const double v = glm::dot(d, q) / det, distance = glm::dot(e2, q) / det;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 && distance < nearest)
            nearest = distance;
    }
    if (std::isinf(nearest)) return std::nullopt;
    return nearest;
}

std::optional<BvhHit> nearest(const Bvh& bvh, const Ray& ray) {
    return nearestHit(bvh, ray.origin, ray.direction, 0.0f, 1e30f);
}

glm::vec3 anyDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    glm::vec3 v(0.0f);
    while (!(glm::length(v) > 1e-3f)) v = {normal(random), normal(random), normal(random)};
    return glm::normalize(v);
}

Bvh bvhOf(const Scene& scene) {
    return buildBvh(scene, poseAt(scene, 0.0));
}

// Triangles of all sizes and directions in a cube of half edge `scale`.
Scene soup(std::uint32_t count, float scale, bool doubleSided = true) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    Scene scene;
    scene.materials.push_back({.doubleSided = doubleSided});
    MeshDraft draft{.name = "soup"};
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::vec3 middle(unit(random), unit(random), unit(random));
        const float size = std::exp(4.0f * unit(random) - 4.0f);
        for (int corner = 0; corner < 3; ++corner) {
            Vertex v;
            v.position = scale * (middle + size * anyDirection(random));
            draft.indices.push_back(static_cast<std::uint32_t>(draft.vertices.size()));
            draft.vertices.push_back(v);
        }
    }
    const Index mesh = addMesh(scene, std::move(draft));
    addInstance(scene, addNode(scene, "soup"), mesh);
    return scene;
}

// A closed ball of radius 1 whose corners are shared.
Scene ball(std::uint32_t rows) {
    Scene scene;
    scene.materials.push_back({.doubleSided = true});
    MeshDraft draft{.name = "ball"};
    const std::uint32_t columns = 2 * rows;
    const auto at = [&](std::uint32_t row, std::uint32_t column) {
        const double theta = 3.14159265358979 * row / rows;
        const double phi = 6.28318530717959 * (column % columns) / columns;
        const double sine = row == 0 || row == rows ? 0.0 : std::sin(theta);
        Vertex v;
        v.position =
            glm::vec3(glm::dvec3(sine * std::cos(phi), std::cos(theta), sine * std::sin(phi)));
        return v;
    };
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const Vertex a = at(row, column), b = at(row + 1, column), c = at(row + 1, column + 1),
                         d = at(row, column + 1);
            for (const Vertex& v : {a, b, c, a, c, d}) {
                draft.indices.push_back(static_cast<std::uint32_t>(draft.vertices.size()));
                draft.vertices.push_back(v);
            }
        }
    }
    const Index mesh = addMesh(scene, std::move(draft));
    addInstance(scene, addNode(scene, "ball"), mesh);
    return scene;
}

void expectSameHits(const Bvh& bvh, float reach, int rays, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    int hits = 0;
    for (int i = 0; i < rays; ++i) {
        const Ray ray{reach * glm::vec3(unit(random), unit(random), unit(random)),
                      anyDirection(random)};
        const auto hit = nearest(bvh, ray);
        const auto expected = plainDistance(bvh, ray);
        ASSERT_EQ(hit.has_value(), expected.has_value()) << i;
        if (!hit) continue;
        ++hits;
        ASSERT_NEAR(hit->distance, *expected, 1e-5 * *expected + 1e-6 * double{reach}) << i;
    }
    EXPECT_GT(hits, rays / 10);
}

TEST(Bvh, IsInDepthFirstOrderWithEachTriangleOnce) {
    const Scene scene = soup(3000, 1.0f);
    const Bvh bvh = bvhOf(scene);
    ASSERT_EQ(bvh.triangles.size(), triangleCount(scene));
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
        const BvhNode& node = bvh.nodes[i];
        ASSERT_GT(node.skip, static_cast<float>(i));
        ASSERT_LE(node.skip, static_cast<float>(bvh.nodes.size()));
        if (node.leaf < 0.0f) continue;
        const auto leaf = static_cast<std::uint32_t>(node.leaf);
        ASSERT_EQ(leaf / kBvhLeafCount, next);
        ASSERT_GT(leaf % kBvhLeafCount, 0u);
        for (std::uint32_t k = 0; k < leaf % kBvhLeafCount; ++k, ++next) {
            const BvhTriangle& t = bvh.triangles[next];
            for (const glm::vec3& p : {t.a, t.b, t.c}) {
                ASSERT_TRUE(glm::all(glm::lessThan(node.low, p)) &&
                            glm::all(glm::lessThan(p, node.high)));
            }
        }
    }
    EXPECT_EQ(next, bvh.triangles.size());
}

TEST(Bvh, AnEmptySceneHasNothingToHit) {
    const Bvh bvh = bvhOf(Scene{});
    EXPECT_TRUE(bvh.nodes.empty());
    EXPECT_FALSE(nearest(bvh, {glm::vec3(0.0f), glm::vec3(0, 0, 1)}));
}

TEST(Bvh, MatchesALinearSearchAtEveryScale) {
    for (const float scale : {1e-4f, 1.0f, 1e3f, 1e6f}) {
        SCOPED_TRACE(scale);
        expectSameHits(bvhOf(soup(2000, scale)), 2.0f * scale, 2000, 1);
    }
}

TEST(Bvh, BackFacesOfSingleSidedSurfacesAreIgnored) {
    expectSameHits(bvhOf(soup(2000, 1.0f, false)), 2.0f, 2000, 2);
}

TEST(Bvh, MatchesALinearSearchInTheChapel) {
    const auto scene = makeBuiltinScene("chapel");
    ASSERT_TRUE(scene);
    const Bvh bvh = bvhOf(*scene);
    EXPECT_EQ(bvh.triangles.size() + bvh.dropped, triangleCount(*scene));
    expectSameHits(bvh, 3.0f, 100, 3);
}

TEST(Bvh, HitsHaveTriangleAndBarycentrics) {
    const Scene scene = soup(500, 1.0f);
    const Bvh bvh = bvhOf(scene);
    std::mt19937 random(4);
    for (int i = 0; i < 500; ++i) {
        const Ray ray{glm::vec3(0.0f), anyDirection(random)};
        const auto hit = nearest(bvh, ray);
        if (!hit) continue;
        ASSERT_EQ(hit->instance, 0u);
        const auto corner = [&](int k) {
            const std::uint32_t index = scene.indices[3 * hit->triangle + k];
            return glm::vec3(glm::dvec3(scene.vertices[index].position) - bvh.origin);
        };
        const glm::vec3 p =
            (1.0f - hit->u - hit->v) * corner(0) + hit->u * corner(1) + hit->v * corner(2);
        ASSERT_LT(glm::length(p - ray.direction * hit->distance), 1e-5f);
    }
}

TEST(Bvh, NoRayLeavesAClosedBallThroughItsSeams) {
    const Bvh bvh = bvhOf(ball(24));
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-0.5f, 0.5f);
    for (int turn = 0; turn < 4; ++turn) {
        for (const BvhTriangle& t : bvh.triangles) {
            const glm::vec3 from(unit(random), unit(random), unit(random));
            // Aimed at a corner, the middles of two edges, and a point near an edge.
            for (const glm::vec3& p : {t.a, 0.5f * (t.a + t.b), 0.5f * (t.b + t.c),
                                       0.3f * t.a + 0.7f * t.c + 1e-7f * t.b}) {
                ASSERT_TRUE(nearest(bvh, {from, p - from}));
            }
        }
    }
    for (int i = 0; i < 200'000; ++i) {
        ASSERT_TRUE(nearest(
            bvh, {glm::vec3(unit(random), unit(random), unit(random)), anyDirection(random)}));
    }
}

TEST(Bvh, AxisParallelRaysAndRaysInAFaceAreFound) {
    const Bvh bvh = bvhOf(ball(16));
    for (int axis = 0; axis < 3; ++axis) {
        for (const float sign : {-1.0f, 1.0f}) {
            for (int k = -9; k <= 9; ++k) {
                glm::vec3 origin(0.0f), direction(0.0f);
                direction[axis] = sign;
                origin[(axis + 1) % 3] = 0.1f * static_cast<float>(k);
                const auto hit = nearest(bvh, {origin, direction});
                ASSERT_TRUE(hit) << axis << " " << k;
                const float half = std::sqrt(1.0f - 0.01f * static_cast<float>(k * k));
                EXPECT_NEAR(hit->distance, half, 0.06f);
            }
        }
    }
    // Along a wall that stands before another one: the wall edge-on is no hit, the other one is.
    Scene scene;
    scene.materials.push_back({.doubleSided = true});
    MeshDraft draft{.name = "walls"};
    for (const glm::vec3 p : {glm::vec3(0, -1, -1), glm::vec3(0, 1, -1), glm::vec3(0, 0, 1),
                              glm::vec3(-1, -1, -3), glm::vec3(1, -1, -3), glm::vec3(0, 2, -3)}) {
        Vertex v;
        v.position = p;
        draft.vertices.push_back(v);
    }
    draft.indices = {0, 1, 2, 3, 4, 5};
    const Index mesh = addMesh(scene, std::move(draft));
    addInstance(scene, addNode(scene, "walls"), mesh);
    const Bvh walls = bvhOf(scene);
    const glm::vec3 from = glm::vec3(glm::dvec3(0, 0, 2) - walls.origin);
    const auto hit = nearest(walls, {from, {0, 0, -1}});
    ASSERT_TRUE(hit);
    EXPECT_FLOAT_EQ(hit->distance, 5.0f);
}

TEST(Bvh, RaysWithoutDirectionHitNothing) {
    const Bvh bvh = bvhOf(ball(8));
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    for (const glm::vec3 d : {glm::vec3(0.0f), glm::vec3(nan, 0, 1), glm::vec3(0, nan, 0),
                              glm::vec3(nan), glm::vec3(inf, 0, 0), glm::vec3(-inf, inf, 1)}) {
        EXPECT_FALSE(nearest(bvh, {glm::vec3(0.0f), d}));
    }
    EXPECT_FALSE(nearest(bvh, {glm::vec3(nan), glm::vec3(0, 0, 1)}));
    EXPECT_FALSE(nearest(bvh, {glm::vec3(inf, 0, 0), glm::vec3(0, 0, 1)}));
}

TEST(Bvh, HitsOutsideTheRangeAreIgnored) {
    const Bvh bvh = bvhOf(ball(32));
    const glm::vec3 from(0, 0, -3), along(0, 0, 1);
    EXPECT_NEAR(nearestHit(bvh, from, along, 0.0f, 10.0f)->distance, 2.0f, 1e-2f);
    EXPECT_NEAR(nearestHit(bvh, from, along, 3.0f, 10.0f)->distance, 4.0f, 1e-2f);
    EXPECT_NEAR(nearestHit(bvh, from, 2.0f * along, 0.0f, 10.0f)->distance, 1.0f, 1e-2f);
    EXPECT_FALSE(nearestHit(bvh, from, along, 0.0f, 1.5f));
    EXPECT_FALSE(nearestHit(bvh, from, along, 5.0f, 10.0f));
}

TEST(Bvh, SidesFollowMirroredInstancesAndMaterials) {
    Scene scene;
    scene.materials = {Material{}, Material{.transmission = 1.0f}};
    MeshDraft draft{.name = "up"};
    for (const glm::vec3 p : {glm::vec3(-1, 0, 1), glm::vec3(1, 0, 1), glm::vec3(0, 0, -2)}) {
        Vertex v;
        v.position = p;
        draft.vertices.push_back(v);
    }
    draft.indices = {0, 1, 2};  // counter-clockwise from above
    const Index mesh = addMesh(scene, std::move(draft));
    glm::dmat4 mirrored(1.0);
    mirrored[0][0] = -1.0;
    const auto seenFrom = [&](const glm::dmat4& place, Index material, float height) {
        Scene one = scene;
        addInstance(one, addNode(one, "node", place), mesh, material);
        return nearest(bvhOf(one), {{0, height, 0}, {0, -height, 0}}).has_value();
    };
    for (const glm::dmat4& place : {glm::dmat4(1.0), mirrored}) {
        EXPECT_TRUE(seenFrom(place, 0, 1.0f));
        EXPECT_FALSE(seenFrom(place, 0, -1.0f));
        EXPECT_TRUE(seenFrom(place, 1, 1.0f));
        EXPECT_TRUE(seenFrom(place, 1, -1.0f));
    }
}

TEST(Bvh, FlatAndInfiniteTrianglesAreDroppedAndCounted) {
    Scene scene = soup(100, 1.0f);
    glm::dmat4 flat(0.0);
    flat[3] = {1, 2, 3, 1};
    addInstance(scene, addNode(scene, "flat", flat), 0);
    addInstance(scene, addNode(scene, "far", glm::dmat4(1e300)), 0);
    const Bvh bvh = buildBvh(scene, poseAt(scene, 0.0));
    EXPECT_EQ(bvh.triangles.size(), 100u);
    EXPECT_EQ(bvh.dropped, 200u);
}

}  // namespace
