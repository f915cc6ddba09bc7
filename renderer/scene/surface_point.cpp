#include "scene/surface_point.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

// World positions; those beyond the primitive's are 0.
std::array<glm::dvec3, 3> cornersOf(const Scene& scene, const Pose& pose, Index instance,
                                    std::uint32_t firstIndex) {
    const Instance& placed = scene.instances[instance];
    const Mesh& mesh = scene.meshes[placed.mesh];
    const MeshVertices vertices = verticesOf(scene, pose, mesh);
    const glm::dmat4& worldFromModel = pose.worldFromNode[placed.node];
    std::array<glm::dvec3, 3> corners{};
    for (std::uint32_t i = 0; i < indicesPer(mesh.primitive); ++i) {
        const glm::dvec3 model(vertices[scene.indices[firstIndex + i]].position);
        corners[i] = glm::dvec3(worldFromModel * glm::dvec4(model, 1.0));
    }
    return corners;
}

// Cramer's rule for origin + t direction = a + u (b - a) + v (c - a).
glm::dvec3 weightsInTriangle(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& origin,
                             const glm::dvec3& direction) {
    const glm::dvec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    const glm::dvec3 from = origin - corners[0];
    const glm::dvec3 across = glm::cross(direction, ac), along = glm::cross(from, ab);
    const double volume = glm::dot(ab, across);
    const double u = glm::dot(from, across) / volume, v = glm::dot(direction, along) / volume;
    if (!std::isfinite(u) || !std::isfinite(v)) return glm::dvec3(1.0 / 3.0);  // seen edge-on
    const glm::dvec3 within = glm::max(glm::dvec3(1.0 - u - v, u, v), 0.0);
    return within / (within.x + within.y + within.z);
}

// The normal equations of the shortest way between a line and a ray.
double placeOnLine(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& origin,
                   const glm::dvec3& direction) {
    const glm::dvec3 along = b - a, from = a - origin;
    const double ll = glm::dot(along, along), ld = glm::dot(along, direction);
    const double dd = glm::dot(direction, direction);
    const double place =
        (ld * glm::dot(direction, from) - dd * glm::dot(along, from)) / (ll * dd - ld * ld);
    return std::isfinite(place) ? std::clamp(place, 0.0, 1.0) : 0.0;
}

}  // namespace

glm::dvec3 positionOf(const Scene& scene, const Pose& pose, const SurfacePoint& point) {
    const auto corners = cornersOf(scene, pose, point.instance, point.firstIndex);
    return point.weights.x * corners[0] + point.weights.y * corners[1] +
           point.weights.z * corners[2];
}

glm::dvec3 normalOf(const Scene& scene, const Pose& pose, const SurfacePoint& point) {
    const Instance& placed = scene.instances[point.instance];
    const Mesh& mesh = scene.meshes[placed.mesh];
    const MeshVertices vertices = verticesOf(scene, pose, mesh);
    const glm::dmat3 worldFromModel(pose.worldFromNode[placed.node]);
    const glm::dmat3 normals = normalMatrix(worldFromModel);
    glm::dvec3 sum(0.0);
    for (std::uint32_t i = 0; i < indicesPer(mesh.primitive); ++i) {
        const glm::dvec3 normal(vertices[scene.indices[point.firstIndex + i]].normal);
        const glm::dvec3 world = normals * normal;
        const double length = glm::length(world);
        if (length > 0.0) sum += point.weights[static_cast<int>(i)] / length * world;
    }
    if (glm::length(sum) > 1e-6) return glm::normalize(sum);
    const auto corners = cornersOf(scene, pose, point.instance, point.firstIndex);
    const glm::dvec3 face = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double area = glm::length(face);
    if (!(area > 0.0)) return {0.0, 1.0, 0.0};
    return (glm::determinant(worldFromModel) < 0.0 ? -1.0 : 1.0) / area * face;
}

SurfacePoint pointAlong(const Scene& scene, const Pose& pose, Index instance,
                        std::uint32_t firstIndex, const glm::dvec3& origin,
                        const glm::dvec3& direction) {
    SurfacePoint point{.instance = instance, .firstIndex = firstIndex};
    const auto corners = cornersOf(scene, pose, instance, firstIndex);
    switch (scene.meshes[scene.instances[instance].mesh].primitive) {
        case Primitive::triangles:
            point.weights = weightsInTriangle(corners, origin, direction);
            break;
        case Primitive::lines: {
            const double place = placeOnLine(corners[0], corners[1], origin, direction);
            point.weights = {1.0 - place, place, 0.0};
            break;
        }
        case Primitive::points:
            break;
    }
    return point;
}

}  // namespace clerestory
