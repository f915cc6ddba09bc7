// A bounding volume hierarchy over the triangles of a posed scene, for rays. Pure; laid out so that
// shaders walk it through texture buffers without a stack.
//
// Of a scene with clips it has two parts under one root, what no clip moves and what some does, so
// that from one moment to the next only the second is built. What a ray meets is the same however
// often that was done: nothing is fitted to an earlier moment.
//
// Does not: shade, know OpenGL.
#pragma once

#include "scene/material_bindings.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory {

// Nodes stand in depth-first order. A ray that meets an inner node's box goes on to the next node;
// one that misses it, or has tested a leaf's triangles, goes on to `skip`, which is the number of
// nodes at the end. The walk only ever goes forward, so it ends whatever the ray. Whole numbers are
// kept as floats, exact up to 2^24: a texture buffer then holds floats alone, and no driver can
// flush small integers to zero.
struct BvhNode {
    glm::vec3 low{0.0f};
    float skip = 0.0f;
    glm::vec3 high{0.0f};
    float leaf = -1.0f;  // kBvhLeafCount * first triangle + how many; -1 for an inner node
};
static_assert(sizeof(BvhNode) == 32);
inline constexpr std::uint32_t kBvhLeafCount = 8;  // more than a leaf's triangles

// Corners and not edges: triangles that share a corner then compute the same numbers from it, and
// no ray slips between them.
struct BvhTriangle {
    glm::vec3 a{0.0f};
    float triangle = 0.0f;  // its number: corners are Scene::indices[3 * triangle ...]
    glm::vec3 b{0.0f};
    float instance = 0.0f;
    glm::vec3 c{0.0f};
    // Which side rays meet: 1 the one that sees a, b, c turn counter-clockwise, -1 the other, 0
    // both.
    float side = 0.0f;
};
static_assert(sizeof(BvhTriangle) == 48);

struct Bvh {
    glm::dvec3 origin{0.0};  // world; everything below is relative to it, in the world's axes
    std::vector<BvhNode> nodes;
    std::vector<BvhTriangle> triangles;
    std::uint64_t dropped = 0;  // without area, not finite, or too many
};

// Everything that is drawn, each instance's triangles where the pose puts them. A side that is not
// drawn is not met: single-sided surfaces turn rays away from the front alone, transmissive ones
// from both sides. An empty scene has no nodes. Triangles above kMaxBvhTriangles are dropped, the
// last first.
inline constexpr std::uint64_t kMaxBvhTriangles = 2'000'000;
Bvh buildBvh(const Scene& scene, const Pose& pose, const MaterialBindings& materials = {});

// The same in two steps, for who keeps the first: buildBvh() is the two joined. The
// pose of the first may be of any moment. A scene in which nothing moves is all still.
Bvh buildStill(const Scene& scene, const Pose& pose, const MaterialBindings& materials = {});
Bvh buildMoving(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
                const Bvh& still);
// One root over both; the still part's nodes stand behind it, then the others. Of a part that is
// empty nothing is left, not even the root.
Bvh joined(const Bvh& still, const Bvh& moving);

struct BvhHit {
    float distance = 0.0f;     // in units of the direction's length
    float u = 0.0f, v = 0.0f;  // weights of b and c
    std::uint32_t triangle = 0, instance = 0;
};
// The nearest hit with a distance in (tMin, tMax): the walk of shaders/include/trace.glsl, step by
// step, for tests and tools. origin: relative to bvh.origin. Nothing for a direction that is zero
// or not finite.
std::optional<BvhHit> nearestHit(const Bvh& bvh, const glm::vec3& origin,
                                 const glm::vec3& direction, float tMin, float tMax);

}  // namespace clerestory
