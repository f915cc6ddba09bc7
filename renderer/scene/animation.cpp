// Interpolation: glTF 2.0, appendix C.
#include "scene/animation.h"

#include "scene/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

constexpr double kMinScale = 1e-6;

glm::dquat unit(const glm::dquat& q) {
    const double length = glm::length(q);
    return length > 1e-12 ? q / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
}

void normalise(std::span<double> xyzw) {
    const glm::dquat q = unit(glm::dquat(xyzw[3], xyzw[0], xyzw[1], xyzw[2]));
    const std::array parts{q.x, q.y, q.z, q.w};
    std::copy(parts.begin(), parts.end(), xyzw.begin());
}

// Along the shorter arc.
void slerp(const float* from, const float* to, double t, std::span<double> out) {
    const auto quaternion = [](const float* v) { return unit(glm::dquat(v[3], v[0], v[1], v[2])); };
    const glm::dquat q = glm::slerp(quaternion(from), quaternion(to), t);
    const std::array parts{q.x, q.y, q.z, q.w};
    std::copy(parts.begin(), parts.end(), out.begin());
    normalise(out);
}

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

glm::dmat4 matrixOf(const Transform& t) {
    const double longest =
        std::max({std::abs(t.scale.x), std::abs(t.scale.y), std::abs(t.scale.z)});
    const double minScale = longest > 0.0 ? kMinScale * longest : kMinScale;
    glm::dmat4 matrix = glm::mat4_cast(t.rotation);
    for (int axis = 0; axis < 3; ++axis) {
        const double s = t.scale[axis];
        matrix[axis] *= std::copysign(std::max(std::abs(s), minScale), s);
    }
    matrix[3] = glm::dvec4(t.translation, 1.0);
    return matrix;
}

std::size_t Track::components() const {
    const std::size_t parts = interpolation == Interpolation::cubicSpline ? 3 : 1;
    return times.empty() ? 0 : values.size() / (parts * times.size());
}

double localTime(const Clip& clip, double time) {
    if (!(clip.duration > 0.0) || !(time > 0.0)) return 0.0;
    return time <= clip.duration ? time : std::fmod(time, clip.duration);
}

void sample(const Track& track, double time, std::span<double> out) {
    const std::vector<float>& times = track.times;
    const std::size_t n = track.components();
    const bool cubic = track.interpolation == Interpolation::cubicSpline;
    const bool isRotation = track.property == AnimatedProperty::rotation;
    const std::size_t stride = cubic ? 3 * n : n;
    // Of key k: part 0 is the in-tangent, 1 the value, 2 the out-tangent.
    const auto part = [&](std::size_t k, std::size_t which) {
        return track.values.data() + k * stride + (cubic ? which * n : 0);
    };
    const auto after = std::upper_bound(times.begin(), times.end(), time,
                                        [](double t, float key) { return t < double{key}; });
    const auto next = static_cast<std::size_t>(after - times.begin());
    const std::size_t k = next > 0 ? next - 1 : 0;
    const bool betweenKeys = next > 0 && next < times.size();
    if (!betweenKeys || track.interpolation == Interpolation::step) {
        std::copy(part(k, 1), part(k, 1) + n, out.begin());
        if (isRotation) normalise(out);
        return;
    }
    // Key k + 1 is after `time` and key k is not: the span is not 0.
    const double span = double{times[k + 1]} - double{times[k]};
    const double s = (time - double{times[k]}) / span;
    if (!cubic && isRotation) return slerp(part(k, 1), part(k + 1, 1), s, out);
    for (std::size_t i = 0; i < n; ++i) {
        const double a = part(k, 1)[i], b = part(k + 1, 1)[i];
        if (!cubic) {
            out[i] = a + (b - a) * s;
            continue;
        }
        const double outTangent = span * part(k, 2)[i], inTangent = span * part(k + 1, 0)[i];
        const double s2 = s * s, s3 = s2 * s;  // Hermite
        out[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * a + (s3 - 2.0 * s2 + s) * outTangent +
                 (3.0 * s2 - 2.0 * s3) * b + (s3 - s2) * inTangent;
    }
    if (isRotation) normalise(out);
}

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
