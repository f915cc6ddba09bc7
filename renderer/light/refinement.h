// A scene with smaller triangles, so that light computed at vertices shows where it changes.
//
//     const Refined fine = refined(scene, restPose(scene), {.addedTriangles = 20'000});
//
// Pure. Nodes, instances, materials, flat parts and deforming meshes stay as they are; so do the
// positions of all vertices. Images keep their sizes and have no texels.
#pragma once

#include "scene/scene.h"

#include <cstdint>

namespace clerestory::light {

struct RefinementLimits {
    std::uint64_t addedTriangles = 12'000;  // at most; edges stay longer if there would be more
    double shortestEdge = 1.0 / 400.0;      // relative to the diagonal of the scene
};

// Edges that are longer in the world than a common length are divided in the middle, until none is
// left. Whether an edge is divided depends on its ends only, so that no gaps open between
// triangles that share it.
struct Refined {
    Scene scene;
    double edge = 0.0;  // the common length, metres; 0: nothing was divided
};
Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits = {});

// The vertices of a mesh: indices first .. first + count of Scene::vertices.
struct VertexRange {
    std::uint32_t first = 0, count = 0;
};
VertexRange vertexRange(const Scene& scene, const Mesh& mesh);

}  // namespace clerestory::light
