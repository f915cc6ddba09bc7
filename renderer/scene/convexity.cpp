#include "scene/convexity.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Of corners with planes. A closed surface of more corners has too many triangles for it.
constexpr std::uint64_t kMaxComparisons = 20'000'000;
constexpr std::size_t kMaxCorners = 20'000;
// Relative to the diagonal of the scene: rounding of corners.
constexpr double kTolerance = 1e-5;

// Calls visit(a, b, c, twoSided) with the corners of each triangle in the world, counter-clockwise
// as its front is seen, until that returns false.
template <class Visit>
bool allTriangles(const Scene& scene, const Pose& pose, Visit visit) {
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.primitive != Primitive::triangles) continue;
        const glm::dmat4& world = pose.worldFromNode[instance.node];
        const bool mirrored = glm::determinant(glm::dmat3(world)) < 0.0;
        const bool twoSided = scene.materials[instance.material].doubleSided;
        const auto corner = [&](std::uint32_t index) {
            return glm::dvec3(
                world * glm::dvec4(glm::dvec3(scene.vertices[scene.indices[index]].position), 1.0));
        };
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            const std::uint32_t end = cluster.firstIndex + cluster.indexCount;
            for (std::uint32_t i = cluster.firstIndex; i + 2 < end; i += 3) {
                const glm::dvec3 b = corner(i + 1), d = corner(i + 2);
                if (!visit(corner(i), mirrored ? d : b, mirrored ? b : d, twoSided)) return false;
            }
        }
    }
    return true;
}

bool changesShape(const Scene& scene) {
    if (!scene.deformations.empty()) return true;
    const std::vector<bool> moves = instancesThatMove(scene);
    return scene.instances.size() > 1 && std::find(moves.begin(), moves.end(), true) != moves.end();
}

}  // namespace

bool isConvex(const Scene& scene, const Pose& pose) {
    if (changesShape(scene)) return false;
    std::vector<glm::dvec3> corners;
    allTriangles(scene, pose, [&](const auto& a, const auto& b, const auto& c, bool) {
        for (const glm::dvec3& p : {a, b, c}) {
            if (corners.empty() || corners.back() != p) corners.push_back(p);
        }
        return corners.size() <= kMaxCorners;
    });
    if (corners.size() > kMaxCorners) return false;
    const double tolerance = kTolerance * double{worldBounds(scene, pose).diagonal()};
    std::uint64_t comparisons = 0;
    return allTriangles(
        scene, pose, [&](const auto& a, const auto& b, const auto& c, bool twoSided) {
            glm::dvec3 normal = glm::cross(b - a, c - a);
            const double length = glm::length(normal);
            if (!(length > 0.0)) return true;
            normal /= length;
            comparisons += corners.size();
            return comparisons <= kMaxComparisons &&
                   std::all_of(corners.begin(), corners.end(), [&](const glm::dvec3& p) {
                       const double height = glm::dot(normal, p - a);
                       return height <= tolerance && (!twoSided || height >= -tolerance);
                   });
        });
}

}  // namespace clerestory
