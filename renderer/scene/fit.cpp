#include "scene/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
    const auto takes = [&](Index instance) {
        return chosen.empty() ? instance != scene.ground : bool(chosen[instance]);
    };
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
    constexpr double kLowest = -std::numeric_limits<double>::max();
    const glm::dvec3 origin = corners.front();
    double right = kLowest, left = kLowest, top = kLowest, bottom = kLowest, nearest = kLowest,
           extent = 0.0;
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

std::vector<glm::dvec3> turnedCorners(std::span<const glm::dvec3> corners, const ViewAxes& axes) {
    constexpr int kSides = 64;  // of the polygon around a circle: 1 / cos(pi / 64) = 1.0012
    glm::dvec3 low = corners.front(), high = low;
    for (const glm::dvec3& corner : corners)
        low = glm::min(low, corner), high = glm::max(high, corner);
    const glm::dvec3 middle = 0.5 * low + 0.5 * high;
    // Only the outline of radius and height can touch the frame: the upper hull over the height.
    std::vector<glm::dvec2> outline;  // height, radius
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 p = corner - middle;
        outline.emplace_back(p.y, std::hypot(p.x, p.z));
    }
    std::sort(outline.begin(), outline.end(), [](const glm::dvec2& a, const glm::dvec2& b) {
        return a.x != b.x ? a.x < b.x : a.y < b.y;
    });
    std::vector<glm::dvec2> hull;
    for (const glm::dvec2& p : outline) {
        const auto bends = [&] {
            const glm::dvec2 a = hull[hull.size() - 2], b = hull.back();
            return (b.x - a.x) * (p.y - a.y) < (b.y - a.y) * (p.x - a.x);
        };
        while (hull.size() >= 2 && !bends()) hull.pop_back();
        hull.push_back(p);
    }
    const glm::dvec3 forth = glm::cross(axes.right, glm::dvec3(0, 1, 0));
    std::vector<glm::dvec3> turned;
    for (const glm::dvec2& ring : hull) {
        for (int i = 0; i < kSides; ++i) {
            const double angle = (i + 0.5) * 2.0 * std::numbers::pi / kSides;
            const double radius = ring.y / std::cos(std::numbers::pi / kSides);
            turned.push_back(middle + glm::dvec3(0, ring.x, 0) +
                             radius * (std::cos(angle) * axes.right + std::sin(angle) * forth));
        }
    }
    return turned;
}

}  // namespace clerestory
