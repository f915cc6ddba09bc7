// Cutting triangles whose edges are too long.
//
//     const Scene fine = refinedWith(edges, scene, restPose(scene));
#pragma once

#include "light/edge_lengths.h"
#include "light/placements.h"

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::light {

// Halvings of an edge: bounds the work for triangles of extreme size.
inline constexpr int kMaxDepth = 24;

// Of a mesh, in any of the places of its placement.
bool isTooLong(const EdgeLengths& edges, const Placement& placement, const glm::dvec3& a,
               const glm::dvec3& b);

// A scene with triangles whose edges are short enough: refined() once the lengths are known, which
// is more than half of its work.
Scene refinedWith(const EdgeLengths& edges, const Scene& scene, const Pose& pose);

// The vertices of a mesh: indices first .. first + count of Scene::vertices.
struct VertexRange {
    std::uint32_t first = 0, count = 0;
};
VertexRange vertexRange(const Scene& scene, const Mesh& mesh);

// Whether meshes share vertices: then none is divided.
bool sharesVertices(const Scene& scene);

// Halves edges for which tooLong(a, b) until none is left, and passes the triangles that result to
// add(a, b, c). Corners may be anything that middle(a, b) is made for.
template <class Corner, class TooLong, class Middle, class Add>
void divide(const Corner& a, const Corner& b, const Corner& c, const TooLong& tooLong,
            const Middle& middle, const Add& add, int depth = 0) {
    const auto further = [&](const Corner& p, const Corner& q, const Corner& r) {
        divide(p, q, r, tooLong, middle, add, depth + 1);
    };
    // The edge p q, or p q and q r.
    const auto one = [&](const Corner& p, const Corner& q, const Corner& r) {
        const Corner x = middle(p, q);
        further(p, x, r);
        further(x, q, r);
    };
    const auto two = [&](const Corner& p, const Corner& q, const Corner& r) {
        const Corner x = middle(p, q), y = middle(q, r);
        further(x, q, y);
        further(p, x, r);
        further(x, y, r);
    };
    const bool ab = depth < kMaxDepth && tooLong(a, b), bc = depth < kMaxDepth && tooLong(b, c),
               ca = depth < kMaxDepth && tooLong(c, a);
    if (ab && bc && ca) {
        const Corner x = middle(a, b), y = middle(b, c), z = middle(c, a);
        further(a, x, z);
        further(x, b, y);
        further(z, y, c);
        further(x, y, z);
    } else if (ab && bc) {
        two(a, b, c);
    } else if (bc && ca) {
        two(b, c, a);
    } else if (ca && ab) {
        two(c, a, b);
    } else if (ab) {
        one(a, b, c);
    } else if (bc) {
        one(b, c, a);
    } else if (ca) {
        one(c, a, b);
    } else {
        add(a, b, c);
    }
}

}  // namespace clerestory::light
