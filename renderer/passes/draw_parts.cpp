#include "passes/draw_parts.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

// Work on a triangle besides its fragments, in fragments.
constexpr double kPerTriangle = 16.0;

double largestScale(const glm::dmat4& m) {
    return std::max({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                     glm::length(glm::dvec3(m[2]))});
}

// 0..1 of the picture: half of the rectangle of a triangle with these corners in clip space; all of
// the picture if it reaches behind the eye.
double shareOf(const std::array<glm::dvec4, 3>& corners) {
    glm::dvec2 low(1.0), high(-1.0);
    int behind = 0;
    for (const glm::dvec4& c : corners) {
        if (!(c.w > 0.0)) {
            ++behind;
            continue;
        }
        const glm::dvec2 p = glm::dvec2(c) / c.w;
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    if (behind > 0) return behind == 3 ? 0.0 : 1.0;
    const glm::dvec2 size = glm::max(
        glm::min(high, glm::dvec2(1.0)) - glm::max(low, glm::dvec2(-1.0)), glm::dvec2(0.0));
    return 0.5 * 0.25 * size.x * size.y;
}

}  // namespace

std::vector<float> clusterAreas(const Scene& scene) {
    std::vector<float> areas(scene.clusters.size(), 0.0f);
    for (const Mesh& mesh : scene.meshes) {
        if (mesh.primitive != Primitive::triangles) continue;
        for (std::uint32_t c = mesh.firstCluster; c < mesh.firstCluster + mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[c];
            double area = 0.0;
            for (std::uint32_t i = 0; i + 2 < cluster.indexCount; i += 3) {
                const auto corner = [&](std::uint32_t k) {
                    return glm::dvec3(
                        scene.vertices[scene.indices[cluster.firstIndex + i + k]].position);
                };
                const glm::dvec3 a = corner(0);
                area += 0.5 * glm::length(glm::cross(corner(1) - a, corner(2) - a));
            }
            areas[c] = static_cast<float>(area);
        }
    }
    return areas;
}

DrawParts::DrawParts(const Scene& scene, std::span<const float> areas, const Pose& pose,
                     const View& view, double pixels)
    : scene_(scene), areas_(areas), pose_(pose), view_(view), pixels_(pixels) {
    const double x = std::abs(view.clipFromView[0][0]), y = std::abs(view.clipFromView[1][1]);
    perArea_ = 0.25 * x * y;
    // A surface in a corner of a wide picture covers more of it.
    if (!view.orthographic) perArea_ *= std::pow(1.0 + 1.0 / (x * x) + 1.0 / (y * y), 1.5);
}

// Share of the picture, or several times it, that the triangles of a cluster may cover together.
double DrawParts::clusterShare(const Draw& draw, std::size_t cluster, const glm::dmat4& toEye,
                               double scale) const {
    const Cluster& c = scene_.clusters[cluster];
    const std::uint32_t drawn =
        std::min(draw.firstIndex + draw.indexCount, c.firstIndex + c.indexCount) -
        std::max(draw.firstIndex, c.firstIndex);
    const double triangles = drawn / 3.0;
    const double share = perArea_ * double{areas_[cluster]} * scale * scale;
    if (view_.orthographic) return std::min(triangles, share);
    const double distance = distanceTo(transformed(c.bounds, toEye));
    return std::min(triangles, share / std::max(distance * distance, 1e-30));
}

double DrawParts::estimate(const Draw& draw) const {
    const Instance& instance = scene_.instances[draw.instance];
    const Mesh& mesh = scene_.meshes[instance.mesh];
    const double primitives = draw.indexCount / indicesPer(draw.primitive);
    if (draw.primitive != Primitive::triangles) {
        const double width = std::max(double{draw.pointSize}, 1.0);
        const double length = draw.primitive == Primitive::lines ? 2.0 * std::sqrt(pixels_) : width;
        return primitives * (std::min(pixels_, width * length) + kPerTriangle);
    }
    // Deformed triangles may be larger than at rest.
    if (mesh.deformation != kNone) return primitives * (pixels_ + kPerTriangle);
    const glm::dmat4& world = pose_.worldFromNode[instance.node];
    const glm::dmat4 toEye = eyeFromLocal(view_, world);
    const double scale = largestScale(world);
    const auto begin = scene_.clusters.begin() + mesh.firstCluster, end = begin + mesh.clusterCount;
    auto at = std::partition_point(begin, end, [&](const Cluster& c) {
        return c.firstIndex + c.indexCount <= draw.firstIndex;
    });
    double share = 0.0;
    for (; at != end && at->firstIndex < draw.firstIndex + draw.indexCount; ++at) {
        share += clusterShare(draw, static_cast<std::size_t>(at - scene_.clusters.begin()), toEye,
                              scale);
    }
    return share * pixels_ + primitives * kPerTriangle;
}

// By the rectangle of each triangle.
void DrawParts::divide(const Draw& draw) {
    const Instance& instance = scene_.instances[draw.instance];
    const Mesh& mesh = scene_.meshes[instance.mesh];
    const DeformedMesh* deformed = nullptr;
    if (mesh.deformation != kNone && mesh.deformation < pose_.deformed.size()) {
        deformed = pose_.deformed[mesh.deformation].get();
    }
    const glm::dmat4 clip =
        view_.clipFromView * view_.viewFromWorld * pose_.worldFromNode[instance.node];
    const auto corner = [&](std::uint32_t i) {
        const std::uint32_t vertex = scene_.indices[i];
        const glm::vec3& position =
            deformed ? deformed->vertices[vertex - deformed->firstVertex].position
                     : scene_.vertices[vertex].position;
        return clip * glm::dvec4(glm::dvec3(position), 1.0);
    };
    const std::uint32_t end = draw.firstIndex + draw.indexCount;
    Part part{.firstIndex = draw.firstIndex};
    for (std::uint32_t i = draw.firstIndex; i + 2 < end; i += 3) {
        const double fragments =
            pixels_ * shareOf({corner(i), corner(i + 1), corner(i + 2)}) + kPerTriangle;
        if (part.indexCount > 0 && part.fragments + fragments > kMaxFragments) {
            parts_.push_back(part);
            part = {.firstIndex = i};
        }
        part.indexCount += 3;
        part.fragments += fragments;
    }
    if (part.indexCount > 0) parts_.push_back(part);
}

std::span<const DrawParts::Part> DrawParts::of(const Draw& draw) {
    parts_.clear();
    const double fragments = estimate(draw);
    if (fragments <= kMaxFragments) {
        parts_.push_back({draw.firstIndex, draw.indexCount, fragments});
        return parts_;
    }
    if (draw.primitive == Primitive::triangles) {
        divide(draw);
        return parts_;
    }
    const std::uint32_t each = indicesPer(draw.primitive), count = draw.indexCount / each;
    const double most = std::max(1.0, std::floor(kMaxFragments / (fragments / count)));
    const auto inPart = static_cast<std::uint32_t>(std::min<double>(most, count));
    for (std::uint32_t first = 0; first < count; first += inPart) {
        const std::uint32_t n = std::min(inPart, count - first);
        parts_.push_back({draw.firstIndex + first * each, n * each, fragments * n / count});
    }
    return parts_;
}

}  // namespace clerestory
