// Where the meshes of a scene are whose vertices show light, and which of their instances share
// triangles when meshes are divided.
//
//     for (const Placement& p : placementsOf(scene, restPose(scene), edges)) ...p.lengthOf(a, b)...
#pragma once

#include "light/edge_lengths.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory::light {

// Instances of one mesh that share its triangles.
struct Placement {
    struct Place {
        glm::dmat4 worldFromMesh{1.0};
        std::uint32_t instance = 0;
    };
    Index mesh = 0;
    std::vector<std::uint32_t> instances;  // ascending
    glm::dmat3 worldFromMesh{1.0};         // with the lengths of the largest instance
    std::vector<Place> places;             // that small bodies may be near to

    // Of the way between two points of the mesh, metres in the world.
    double lengthOf(const glm::dvec3& a, const glm::dvec3& b) const {
        return glm::length(worldFromMesh * (a - b));
    }
};

// Whether light is computed at the vertices of an instance of a mesh that is divided.
bool isDivided(const Scene& scene, const std::vector<bool>& moves, std::size_t instance);

// In the order of meshes. Instances of one size share triangles; those that a small body of `edges`
// is near to have their own. Where that would be too many copies of triangles, all instances of a
// mesh share them, and small bodies near to more than a few of them are not regarded.
std::vector<Placement> placementsOf(const Scene& scene, const Pose& pose, const EdgeLengths& edges);

// Calls add(corners) for each triangle of a mesh; corners: three indices of Scene::vertices.
template <class Add>
void eachTriangle(const Scene& scene, const Mesh& mesh, const Add& add) {
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
        for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
            add(&scene.indices[cluster.firstIndex + i]);
        }
    }
}

}  // namespace clerestory::light
