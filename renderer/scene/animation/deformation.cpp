// Linear blending in double: morph targets, then joints.
#include "scene/animation/deformation.h"

#include "scene/finite.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// The unit vector of v; `fallback` if v has no direction.
glm::vec3 unit(const glm::dvec3& v, const glm::vec3& fallback) {
    const double length = glm::length(v);
    return length > 1e-30 && std::isfinite(length) ? glm::vec3(v / length) : fallback;
}

glm::vec3 anyPerpendicular(const glm::vec3& n) {
    const glm::vec3 axis = std::abs(n.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return glm::normalize(axis - glm::dot(axis, n) * n);
}

glm::vec4 orthogonalTangent(const glm::vec3& normal, const glm::dvec3& along, float side) {
    const glm::dvec3 n(normal);
    const double length = glm::length(along);
    const glm::dvec3 flat = length > 0.0 ? along / length - glm::dot(along / length, n) * n : along;
    const bool valid = glm::length(flat) > 1e-4 && finite(flat);
    return {valid ? glm::vec3(glm::normalize(flat)) : anyPerpendicular(normal), side};
}

struct Sum {
    glm::dvec3 position, normal, tangent;
};

std::vector<Sum> morphed(const Deformation& d, std::span<const double> weights) {
    std::vector<Sum> sums;
    sums.reserve(d.base.size());
    for (const BaseVertex& v : d.base) {
        sums.push_back({v.position, v.normal, glm::vec3(v.tangent)});
    }
    for (std::size_t t = 0; t + 1 < d.firstDelta.size() && t < weights.size(); ++t) {
        const double weight = weights[t];
        if (weight == 0.0) continue;
        for (std::uint32_t i = d.firstDelta[t]; i < d.firstDelta[t + 1]; ++i) {
            const MorphDelta& delta = d.deltas[i];
            Sum& sum = sums[delta.vertex];
            sum.position += weight * glm::dvec3(delta.position);
            sum.normal += weight * glm::dvec3(delta.normal);
            sum.tangent += weight * glm::dvec3(delta.tangent);
        }
    }
    return sums;
}

void skinned(const Deformation& d, std::span<const glm::dmat4> worldFromJointBind,
             std::vector<Sum>& sums) {
    for (std::size_t i = 0; i < sums.size(); ++i) {
        glm::dmat4 m(0.0);
        for (std::uint32_t k = 0; k < d.perVertex; ++k) {
            const Influence& influence = d.influences[i * d.perVertex + k];
            if (influence.share > 0.0f) {
                m += double{influence.share} * worldFromJointBind[influence.joint];
            }
        }
        Sum& sum = sums[i];
        sum.position = glm::dvec3(m * glm::dvec4(sum.position, 1.0));
        const glm::dmat3 turn(m);
        // The cofactor matrix: the inverse transpose times the determinant.
        const glm::dmat3 cofactor(glm::cross(turn[1], turn[2]), glm::cross(turn[2], turn[0]),
                                  glm::cross(turn[0], turn[1]));
        const double side = glm::determinant(turn) < 0.0 ? -1.0 : 1.0;
        sum.normal = side * (cofactor * sum.normal);
        sum.tangent = turn * sum.tangent;
    }
}

}  // namespace

void deform(const Deformation& d, std::span<const double> weights,
            std::span<const glm::dmat4> worldFromJointBind, std::span<const Vertex> rest,
            std::vector<Vertex>& out) {
    std::vector<Sum> sums = morphed(d, weights);
    if (!worldFromJointBind.empty()) skinned(d, worldFromJointBind, sums);
    out.assign(rest.begin(), rest.end());
    for (std::size_t i = 0; i < out.size(); ++i) {
        Vertex& v = out[i];
        const glm::vec3 position(sums[i].position);
        if (finite(position)) v.position = position;
        v.normal = unit(sums[i].normal, v.normal);
        v.tangent = orthogonalTangent(v.normal, sums[i].tangent, d.base[i].tangent.w);
    }
}

void flattenNormals(std::span<const std::uint32_t> indices, std::uint32_t first,
                    std::span<Vertex> vertices) {
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        Vertex* corner[3];
        for (std::size_t k = 0; k < 3; ++k) corner[k] = &vertices[indices[i + k] - first];
        const glm::dvec3 a(corner[0]->position), b(corner[1]->position), c(corner[2]->position);
        const glm::dvec3 across = glm::cross(b - a, c - a);
        for (Vertex* v : corner) {
            v->normal = unit(across, v->normal);
            v->tangent = orthogonalTangent(v->normal, glm::vec3(v->tangent), v->tangent.w);
        }
    }
}

}  // namespace clerestory
