#include "light/refinement.h"

#include "light/division.h"
#include "light/placements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clerestory::light {
namespace {

// A body is small below this multiple of the common length.
constexpr double kSmall = 8.0;
constexpr std::size_t kMaxSmall = 64;  // the largest of them
constexpr double kFlat = 0.01;         // thickness over the greatest extent of a flat light
// Triangles in meshes of instances that do not share them, in units of those that would be added.
constexpr std::uint64_t kMaxCopies = 8;
// So many instances that share triangles count as one.
constexpr std::size_t kSharing = 4;
// Length of edges relative to the size of the body: at least, and at most where it pays.
constexpr double kFinest = 0.05, kCoarsest = 0.4;

struct Triangle {
    glm::dvec3 corners[3];  // of the mesh
    double longest = 0.0;   // edge, world
    const Placement* placement = nullptr;
};

std::vector<Triangle> trianglesOf(const Scene& scene, const std::vector<Placement>& placements) {
    std::vector<Triangle> triangles;
    for (const Placement& placement : placements) {
        eachTriangle(scene, scene.meshes[placement.mesh], [&](const std::uint32_t* corners) {
            Triangle t{.placement = &placement};
            for (int k = 0; k < 3; ++k) {
                t.corners[k] = glm::dvec3(scene.vertices[corners[k]].position);
            }
            for (int k = 0; k < 3; ++k) {
                t.longest =
                    std::max(t.longest, placement.lengthOf(t.corners[k], t.corners[(k + 1) % 3]));
            }
            triangles.push_back(t);
        });
    }
    return triangles;
}

// Triangles that one is divided into; somewhat more than `limit` if there would be more.
std::uint64_t countOfParts(const Triangle& t, const EdgeLengths& edges, std::uint64_t limit) {
    std::uint64_t count = 0;
    divide(
        t.corners[0], t.corners[1], t.corners[2],
        [&](const glm::dvec3& a, const glm::dvec3& b) {
            return count <= limit && isTooLong(edges, *t.placement, a, b);
        },
        [](const glm::dvec3& a, const glm::dvec3& b) { return 0.5 * (a + b); },
        [&](const auto&, const auto&, const auto&) { ++count; });
    return count;
}

// Triangles that are added; somewhat more than `limit` if there would be more. Those that many
// instances share count as several, because they are drawn and lit as often.
std::uint64_t countOfAdded(const std::vector<Triangle>& triangles, const EdgeLengths& edges,
                           std::uint64_t limit) {
    double shortest = edges.common;
    if (!edges.small.empty()) {
        shortest = std::min(shortest, edges.perSize * edges.small.back().size);
    }
    std::uint64_t added = 0;
    for (const Triangle& t : triangles) {
        if (!(t.longest > shortest)) continue;
        const std::uint64_t drawn =
            std::max(t.placement->instances.size() / kSharing, std::size_t{1});
        added += drawn * (countOfParts(t, edges, (limit - added) / drawn + 1) - 1);
        if (added > limit) return added;
    }
    return added;
}

// The smallest value with which no more triangles than `limit` are added, and which is at least
// `low`; `high` if there is none. set: sets the value. steps: of the bisection.
template <class Set>
double smallestWithin(const std::vector<Triangle>& triangles, EdgeLengths edges, double low,
                      double high, std::uint64_t limit, int steps, const Set& set) {
    const auto isEnough = [&](double value) {
        set(edges, value);
        return countOfAdded(triangles, edges, limit) <= limit;
    };
    if (isEnough(low)) return low;
    for (int i = 0; i < steps; ++i) {
        const double middle = std::sqrt(low * high);
        (isEnough(middle) ? high : low) = middle;
    }
    return high;
}

// The part of a ceiling that a flat light covers is as bright as the light, and short triangles
// across the light's edge would show that. box: of the mesh.
bool isFlatEmitter(const Material& material, const Bounds& box, const glm::dmat4& worldFromMesh) {
    if (emittedRadiance(material) == glm::vec3(0.0f)) return false;
    glm::dvec3 extent(box.max - box.min);
    for (int k = 0; k < 3; ++k) extent[k] *= glm::length(glm::dvec3(worldFromMesh[k]));
    return std::min({extent.x, extent.y, extent.z}) <
           kFlat * std::max({extent.x, extent.y, extent.z});
}

// The largest first.
std::vector<EdgeLengths::Body> smallBodies(const Scene& scene, const Pose& pose, double common) {
    const std::vector<bool> moves = instancesThatMove(scene);
    std::vector<EdgeLengths::Body> bodies;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (!isDivided(scene, moves, i)) continue;
        Bounds box;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            box.add(scene.clusters[mesh.firstCluster + c].bounds);
        }
        const glm::dmat4& worldFromMesh = pose.worldFromNode[instance.node];
        if (isFlatEmitter(scene.materials[instance.material], box, worldFromMesh)) continue;
        box = transformed(box, worldFromMesh);
        const double size = box.diagonal();
        if (size > 0.0 && size < kSmall * common) {
            bodies.push_back({box, size, static_cast<std::uint32_t>(i)});
        }
    }
    std::stable_sort(bodies.begin(), bodies.end(),
                     [](const auto& a, const auto& b) { return a.size > b.size; });
    if (bodies.size() > kMaxSmall) bodies.resize(kMaxSmall);
    return bodies;
}

EdgeLengths edgeLengthsFor(const Scene& scene, const Pose& pose, const RefinementLimits& limits) {
    const double diagonal = lastingBounds(scene, pose).diagonal();
    const double shortest = limits.shortestEdge * diagonal;
    EdgeLengths edges;
    {
        const std::vector<Placement> placements = placementsOf(scene, pose, edges);
        edges.common = smallestWithin(trianglesOf(scene, placements), edges, shortest,
                                      std::max(shortest, diagonal), limits.addedTriangles, 24,
                                      [](EdgeLengths& e, double v) { e.common = v; });
    }
    // The smaller half of the bodies is left out as long as there would be too many triangles.
    for (edges.small = smallBodies(scene, pose, edges.common); !edges.small.empty();
         edges.small.resize(edges.small.size() / 2)) {
        edges.perSize = kFinest;
        const std::vector<Placement> placements = placementsOf(scene, pose, edges);
        const std::vector<Triangle> triangles = trianglesOf(scene, placements);
        const std::uint64_t limit =
            countOfAdded(triangles, {.common = edges.common}, kMaxCopies * limits.addedTriangles) +
            limits.addedNearBodies;
        edges.perSize = smallestWithin(triangles, edges, kFinest, kCoarsest, limit, 8,
                                       [](EdgeLengths& e, double v) { e.perSize = v; });
        if (edges.perSize < kCoarsest) break;
    }
    return edges;
}

}  // namespace

Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits) {
    EdgeLengths edges;
    if (!sharesVertices(scene)) edges = edgeLengthsFor(scene, pose, limits);
    Scene fine = refinedWith(edges, scene, pose);
    return {std::move(fine), std::move(edges)};
}

}  // namespace clerestory::light
