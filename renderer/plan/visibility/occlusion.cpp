// A box is hidden when the eye's lines to all its corners end beyond one wall that they cross: the
// box lies in the cone of its corners, and the wall is convex.
#include "plan/visibility/occlusion.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

// The four corners of two triangles that share a diagonal and make a parallelogram: the first
// edge's start, and its neighbours. Nothing for any other pair.
std::optional<std::array<glm::dvec3, 3>> parallelogram(const Scene& scene,
                                                       std::uint32_t firstIndex) {
    const auto at = [&](std::uint32_t i) {
        return glm::dvec3(scene.vertices[scene.indices[firstIndex + i]].position);
    };
    // The corner of each triangle that the other does not have, and the two that both have.
    for (std::uint32_t lone = 0; lone < 3; ++lone) {
        const glm::dvec3 a = at(lone), b = at((lone + 1) % 3), c = at((lone + 2) % 3);
        for (std::uint32_t other = 0; other < 3; ++other) {
            // The second triangle runs along the shared edge the other way.
            if (at(3 + (other + 1) % 3) != c || at(3 + (other + 2) % 3) != b) continue;
            const glm::dvec3 d = at(3 + other);
            const double size = glm::length(b - a) + glm::length(c - a);
            if (glm::length(b + c - a - d) > 1e-6 * size) return std::nullopt;
            return std::array{a, b, c};
        }
    }
    return std::nullopt;
}

}  // namespace

std::vector<Wall> wallsOf(const Stage& stage, const View& view) {
    std::vector<Wall> walls;
    if (view.orthographic || view.clipPlane) return walls;
    for (std::size_t i = 0; i < stage.surfaces.size(); ++i) {
        const Surface& surface = stage.surfaces[i];
        if (surface.clusterCount != 1 || surface.glass != Glass::none) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        if (stage.scene.meshes[instance.mesh].deformation != kNone) continue;
        const Cluster& cluster = stage.scene.clusters[surface.firstCluster];
        const Material& material = stage.material(surface);
        if (cluster.indexCount != 6 || material.alphaMode != AlphaMode::opaque) continue;
        const auto corners = parallelogram(stage.scene, cluster.firstIndex);
        if (!corners) continue;
        const glm::dmat4 toEye = eyeFromLocal(view, stage.pose.worldFromNode[instance.node]);
        const auto placed = [&](const glm::dvec3& p) {
            return glm::dvec3(toEye * glm::dvec4(p, 1.0));
        };
        const auto& [a, b, c] = *corners;
        const Wall wall{placed(a), placed(b) - placed(a), placed(c) - placed(a), i};
        // a, b, c turn counter-clockwise for who sees the front; a mirrored instance turns them.
        const glm::dvec3 normal = glm::cross(wall.edge1, wall.edge2);
        const double towards = -glm::dot(normal, wall.corner) *
                               (glm::determinant(glm::dmat3(toEye)) < 0.0 ? -1.0 : 1.0);
        if (towards > 0.0 || material.doubleSided) walls.push_back(wall);
    }
    return walls;
}

const Wall* hiding(std::span<const Wall> walls, const View& view, const Bounds& box) {
    if (box.empty()) return nullptr;
    const glm::dvec3 forward = -glm::transpose(glm::dmat3(view.viewFromWorld))[2];
    const auto hides = [&](const Wall& wall) {
        const glm::dvec3 normal = glm::cross(wall.edge1, wall.edge2);
        const double plane = glm::dot(normal, wall.corner);
        const double area = glm::dot(normal, normal);
        for (int i = 0; i < 8; ++i) {
            const glm::dvec3 corner(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                    i & 4 ? box.max.z : box.min.z);
            const double along = glm::dot(normal, corner) / plane;
            if (!(along > 1.0 + 1e-6)) return false;  // before the wall, in it, or behind the eye
            const glm::dvec3 crossing = corner / along;
            if (!(glm::dot(forward, crossing) > view.znear)) return false;  // clipped away there
            const glm::dvec3 p = crossing - wall.corner;
            const double u = glm::dot(glm::cross(p, wall.edge2), normal) / area;
            const double v = glm::dot(glm::cross(wall.edge1, p), normal) / area;
            if (!(u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0)) return false;
        }
        return true;
    };
    const auto found = std::find_if(walls.begin(), walls.end(), hides);
    return found == walls.end() ? nullptr : &*found;
}

}  // namespace clerestory
