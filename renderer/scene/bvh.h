// A bounding volume hierarchy over the triangles of a posed scene, for ray tracing. Its layout lets
// shaders traverse it through texture buffers without a stack.
//
// In a scene with clips it has two parts below one root, a static and a dynamic one, so that only
// the second is rebuilt for another time. It is rebuilt and never refitted: the hits do not depend
// on earlier poses.
//
// Does not: shade, use OpenGL.
#pragma once

#include "scene/scene.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory {

// Nodes are in depth-first order. If a ray hits the box of an inner node, the next node follows; if
// it misses the box, or after a leaf, `skip` follows, which is the number of nodes at the end.
// Indices only increase, so traversal always ends. Integers are stored as floats, exact up to 2^24:
// the texture buffer then has floats only, and no driver can flush small integers to zero.
struct BvhNode {
    glm::vec3 low{0.0f};
    float skip = 0.0f;
    glm::vec3 high{0.0f};
    float leaf = -1.0f;  // kBvhLeafCount * first triangle + count; -1 for an inner node
};
static_assert(sizeof(BvhNode) == 32);
inline constexpr std::uint32_t kBvhLeafCount =
    8;  // above the largest number of triangles in a leaf

// Corners instead of edges: triangles that share a corner compute the same values from it, so that
// no ray passes between them.
struct BvhTriangle {
    glm::vec3 a{0.0f};
    float triangle = 0.0f;  // its corners are Scene::indices[3 * triangle ...]
    glm::vec3 b{0.0f};
    float instance = 0.0f;
    glm::vec3 c{0.0f};
    // The side that rays hit: 1 where a, b, c are counter-clockwise, -1 the other, 0 both.
    float side = 0.0f;
};
static_assert(sizeof(BvhTriangle) == 48);

struct Bvh {
    glm::dvec3 origin{0.0};  // world; everything below is relative to it, in the world's axes
    std::vector<BvhNode> nodes;
    std::vector<BvhTriangle> triangles;
    std::uint64_t dropped = 0;  // degenerate, not finite, or above the limit
};

// All triangles of all instances in the pose. Rays hit single-sided surfaces from the front only,
// transmissive ones from both sides. An empty scene has no nodes. Triangles above kMaxBvhTriangles
// are dropped, the last ones first.
inline constexpr std::uint64_t kMaxBvhTriangles = 2'000'000;
Bvh buildBvh(const Scene& scene, const Pose& pose, const MaterialBindings& materials = {});

// The two parts of buildBvh(), for callers that cache the first one. The static part is the same
// for every pose. A scene without animation has only a static part.
Bvh buildStill(const Scene& scene, const Pose& pose, const MaterialBindings& materials = {});
Bvh buildMoving(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
                const Bvh& still);
// One root over both: the static nodes follow it, then the dynamic ones. If a part is empty, the
// result is the other part.
Bvh joined(const Bvh& still, const Bvh& moving);

// For each instance what its material decides about its triangles: the side that rays hit, and
// whether there are any. If it is equal, so are the triangles of one pose.
std::vector<float> sidesOf(const Scene& scene, const MaterialBindings& materials);

// The triangles of both parts without a hierarchy, for other builders.
struct BvhTriangles {
    glm::dvec3 origin{0.0};  // world; as Bvh::origin
    std::vector<BvhTriangle> triangles;
};
BvhTriangles stillTriangles(const Scene& scene, const Pose& pose,
                            const MaterialBindings& materials = {});
// stillCount: number of triangles of the other part.
BvhTriangles movingTriangles(const Scene& scene, const Pose& pose,
                             const MaterialBindings& materials, std::size_t stillCount);

struct BvhHit {
    float distance = 0.0f;     // in units of the direction's length
    float u = 0.0f, v = 0.0f;  // weights of b and c
    std::uint32_t triangle = 0, instance = 0;
};
// The nearest hit with a distance in (tMin, tMax), computed as in shaders/include/trace.glsl, for
// tests and tools. origin: relative to bvh.origin. Nothing if the direction is zero or not finite.
std::optional<BvhHit> nearestHit(const Bvh& bvh, const glm::vec3& origin,
                                 const glm::vec3& direction, float tMin, float tMax);

}  // namespace clerestory
