#include "scene/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory {

ViewAxes uprightAxes(const glm::dvec3& back) {
    constexpr double kParallel = 1e-9;  // sine of the angle to the vertical; as worldFromLookAt()
    glm::dvec3 right = glm::cross(glm::dvec3(0, 1, 0), back);
    if (!(glm::length(right) > kParallel)) right = glm::cross(glm::dvec3(0, 0, -1), back);
    right = glm::normalize(right);
    return {right, glm::cross(back, right), back};
}

glm::dvec3 directionTo(double azimuth, double elevation) {
    const double level = std::cos(elevation);
    return {level * std::sin(azimuth), std::sin(elevation), level * std::cos(azimuth)};
}

std::vector<glm::dvec3> cornersOf(const Scene& scene, const Pose& pose,
                                  const std::vector<bool>& chosen, std::size_t most) {
    const auto takes = [&](Index instance) { return chosen.empty() || chosen[instance]; };
    std::uint64_t primitives = 0;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        if (takes(i)) primitives += scene.meshes[scene.instances[i].mesh].primitives;
    }
    const std::uint64_t step = 1 + 3 * primitives / most;
    std::vector<glm::dvec3> corners;
    corners.reserve(static_cast<std::size_t>(3 * primitives / step + 3));
    std::uint64_t number = 0;
    for (Index instance = 0; instance < scene.instances.size(); ++instance) {
        if (!takes(instance)) continue;
        const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
        const MeshVertices vertices = verticesOf(scene, pose, mesh);
        const glm::dmat4& worldFromMesh = pose.worldFromNode[scene.instances[instance].node];
        for (std::uint32_t k = 0; k < mesh.clusterCount; ++k) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + k];
            const std::uint32_t each = indicesPer(mesh.primitive);
            for (std::uint32_t i = 0; i < cluster.indexCount; i += each) {
                if (number++ % step != 0) continue;
                for (std::uint32_t corner = 0; corner < 3; ++corner) {
                    const std::uint32_t index =
                        scene.indices[cluster.firstIndex + i + std::min(corner, each - 1)];
                    corners.emplace_back(worldFromMesh * glm::dvec4(vertices[index].position, 1.0));
                }
            }
        }
    }
    return corners;
}

// A corner at x and z along right and back is left of the frame's right side if
// x - eye.x <= right (eye.z - z): the largest x + right z over all corners bounds the eye, and so
// do the other sides. Both bounds of a direction meet at its nearest eye.
glm::dvec3 fittedEye(std::span<const glm::dvec3> corners, const ViewAxes& axes,
                     const FrameTangents& frame) {
    constexpr double kNone = -std::numeric_limits<double>::max();
    const glm::dvec3 origin = corners.front();
    double right = kNone, left = kNone, top = kNone, bottom = kNone, nearest = kNone, extent = 0.0;
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 p = corner - origin;
        const double x = glm::dot(p, axes.right), y = glm::dot(p, axes.up),
                     z = glm::dot(p, axes.back);
        right = std::max(right, x + frame.right * z);
        left = std::max(left, -x + frame.left * z);
        top = std::max(top, y + frame.top * z);
        bottom = std::max(bottom, -y + frame.bottom * z);
        nearest = std::max(nearest, z);
        extent = std::max(extent, glm::length(p));
    }
    const double least = extent > 0.0 ? std::max(0.01 * extent, 1e-6) : 1.0;  // of a single point
    const double z = std::max({(right + left) / (frame.right + frame.left),
                               (top + bottom) / (frame.top + frame.bottom), nearest + least});
    // In the middle between both bounds.
    const double x = 0.5 * ((right - frame.right * z) + (frame.left * z - left));
    const double y = 0.5 * ((top - frame.top * z) + (frame.bottom * z - bottom));
    return origin + x * axes.right + y * axes.up + z * axes.back;
}

}  // namespace clerestory
