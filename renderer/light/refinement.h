// A scene with smaller triangles, so that light computed at vertices shows where it changes.
//
//     const Refined fine = refined(scene, restPose(scene), {.addedTriangles = 20'000});
//
// Pure. Nodes, instances, materials, flat parts and deforming meshes stay as they are; so do the
// positions of all vertices. Images keep their sizes and have no texels.
#pragma once

#include "scene/scene.h"

#include <cstdint>
#include <vector>

namespace clerestory::light {

struct RefinementLimits {
    std::uint64_t addedTriangles = 12'000;  // at most; edges stay longer if there would be more
    double shortestEdge = 1.0 / 400.0;      // relative to the diagonal of the scene
    std::uint64_t addedNearBodies = 6'000;  // at most, and next to small bodies only
};

// How long edges may be. There is a common length; next to bodies that are small compared with it,
// such as an object on a wide floor, light changes over a fraction of their size, and edges are
// shorter.
struct EdgeLengths {
    struct Body {
        Bounds box;  // world
        double size = 0.0;
        std::uint32_t instance = 0;
    };
    double common = 0.0;  // metres; 0: nothing was divided
    std::vector<Body> small;
    double perSize = 0.0;  // length at a small body, relative to its size

    // At a point of the world, next to all small bodies but that of one instance.
    double at(const glm::dvec3& world, std::uint32_t except = ~0u) const;
    // Whether it is less than `length` there.
    bool below(double length, const glm::dvec3& world, std::uint32_t except = ~0u) const;
};

// Edges that are longer in the world are divided in the middle, until none is left. Whether an edge
// of a mesh is divided depends on its ends only, so that no gaps open between triangles that share
// it. The body that a mesh is does not shorten its own edges.
struct Refined {
    Scene scene;
    EdgeLengths edges;
};
Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits = {});
// The same scene again, from the lengths that were found for it, which is more than half of the
// work.
Scene refinedWith(const EdgeLengths& edges, const Scene& scene, const Pose& pose);

// The vertices of a mesh: indices first .. first + count of Scene::vertices.
struct VertexRange {
    std::uint32_t first = 0, count = 0;
};
VertexRange vertexRange(const Scene& scene, const Mesh& mesh);

}  // namespace clerestory::light
