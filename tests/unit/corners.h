// The triangles of a posed scene.
#pragma once

#include "scene/scene.h"

namespace clerestory::test {

// Calls `each` with the three corners in the world, glm::dvec3, of every triangle.
template <class Each>
void forEachTriangle(const Scene& scene, const Pose& pose, Each&& each) {
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        const glm::dmat4& world = pose.worldFromNode[instance.node];
        const MeshVertices vertices = verticesOf(scene, pose, mesh);
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                const auto corner = [&](std::uint32_t k) {
                    const Vertex& v = vertices[scene.indices[cluster.firstIndex + i + k]];
                    return glm::dvec3(world * glm::dvec4(v.position, 1.0));
                };
                each(corner(0), corner(1), corner(2));
            }
        }
    }
}

}  // namespace clerestory::test
