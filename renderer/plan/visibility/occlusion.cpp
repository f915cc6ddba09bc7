// A box is hidden if the segments from the eye to its eight corners all cross one occluder: the box
// is inside the cone of its corners, and the occluder is convex.
#include "plan/visibility/occlusion.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

// Returns one corner and its two neighbours if two triangles share a diagonal and form a
// parallelogram.
std::optional<std::array<glm::dvec3, 3>> parallelogram(const Scene& scene,
                                                       std::uint32_t firstIndex) {
    const auto at = [&](std::uint32_t i) {
        return glm::dvec3(scene.vertices[scene.indices[firstIndex + i]].position);
    };
    // `lone` and `other`: the corners that the triangles do not share.
    for (std::uint32_t lone = 0; lone < 3; ++lone) {
        const glm::dvec3 a = at(lone), b = at((lone + 1) % 3), c = at((lone + 2) % 3);
        for (std::uint32_t other = 0; other < 3; ++other) {
            // The second triangle has the shared edge in the opposite direction.
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

std::vector<Occluder> occludersOf(const Stage& stage, const View& view) {
    std::vector<Occluder> occluders;
    if (view.orthographic || view.clipPlane) return occluders;
    for (std::size_t i = 0; i < stage.surfaces.size(); ++i) {
        const Surface& surface = stage.surfaces[i];
        if (surface.clusterCount != 1 || surface.glass != Glass::none) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        const Mesh& mesh = stage.scene.meshes[instance.mesh];
        if (mesh.primitive != Primitive::triangles || mesh.deformation != kNone) continue;
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
        const Occluder occluder{placed(a), placed(b) - placed(a), placed(c) - placed(a), i};
        // a, b, c are counter-clockwise seen from the front; a mirrored instance reverses them.
        const glm::dvec3 normal = glm::cross(occluder.edge1, occluder.edge2);
        const double towards = -glm::dot(normal, occluder.corner) *
                               (glm::determinant(glm::dmat3(toEye)) < 0.0 ? -1.0 : 1.0);
        if (towards > 0.0 || material.doubleSided) occluders.push_back(occluder);
    }
    return occluders;
}

const Occluder* findOccluder(std::span<const Occluder> occluders, const View& view,
                             const Bounds& box) {
    if (box.empty()) return nullptr;
    const glm::dvec3 forward = -glm::transpose(glm::dmat3(view.viewFromWorld))[2];
    const auto hides = [&](const Occluder& occluder) {
        const glm::dvec3 normal = glm::cross(occluder.edge1, occluder.edge2);
        const double plane = glm::dot(normal, occluder.corner);
        const double area = glm::dot(normal, normal);
        for (int i = 0; i < 8; ++i) {
            const glm::dvec3 corner(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                    i & 4 ? box.max.z : box.min.z);
            const double along = glm::dot(normal, corner) / plane;
            if (!(along > 1.0 + 1e-6)) return false;  // in front, or behind the eye
            const glm::dvec3 crossing = corner / along;
            if (!(glm::dot(forward, crossing) > view.znear)) return false;  // clipped away there
            const glm::dvec3 p = crossing - occluder.corner;
            const double u = glm::dot(glm::cross(p, occluder.edge2), normal) / area;
            const double v = glm::dot(glm::cross(occluder.edge1, p), normal) / area;
            if (!(u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0)) return false;
        }
        return true;
    };
    const auto found = std::find_if(occluders.begin(), occluders.end(), hides);
    return found == occluders.end() ? nullptr : &*found;
}

}  // namespace clerestory
