// A scene with smaller triangles, so that light computed at vertices shows where it changes.
//
//     const Refined fine = refined(scene, restPose(scene), {.addedTriangles = 20'000});
//
// Pure. Nodes, materials and deforming meshes stay as they are; so do the positions of all vertices
// and all instances, but some have copies of their meshes, which are divided in other ways. Images
// keep their sizes and have no texels.
#pragma once

#include "light/edge_lengths.h"
#include "scene/scene.h"

#include <cstdint>

namespace clerestory::light {

struct RefinementLimits {
    std::uint64_t addedTriangles = 12'000;  // at most; edges stay longer if there would be more
    double shortestEdge = 1.0 / 400.0;      // relative to the diagonal of the scene
    std::uint64_t addedNearBodies = 6'000;  // at most, and next to small bodies only
};

// Edges that are longer in the world are divided in the middle, until none is left. Whether an edge
// of a mesh is divided depends on its ends only, so that no gaps open between triangles that share
// it. The body that a mesh is does not shorten its own edges.
struct Refined {
    Scene scene;
    EdgeLengths edges;
};
Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits = {});

}  // namespace clerestory::light
