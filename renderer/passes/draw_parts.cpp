#include "passes/draw_parts.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

// Work on a triangle besides its fragments, in fragments.
constexpr double kPerTriangle = 16.0;
// Clusters with more are estimated again by their triangles.
constexpr double kFewFragments = 2e6;

double largestScale(const glm::dmat4& m) {
    return std::max({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                     glm::length(glm::dvec3(m[2]))});
}

// 0..1 of the picture: half of the rectangle of a triangle with these corners in clip space; all of
// the picture if it reaches behind the eye.
float shareOfTriangle(const std::array<glm::vec4, 3>& corners) {
    glm::vec2 low(1.0f), high(-1.0f);
    int behind = 0;
    for (const glm::vec4& c : corners) {
        if (!(c.w > 0.0f)) {
            ++behind;
            continue;
        }
        const glm::vec2 p = glm::vec2(c) / c.w;
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    if (behind > 0) return behind == 3 ? 0.0f : 1.0f;
    const glm::vec2 size = glm::max(
        glm::min(high, glm::vec2(1.0f)) - glm::max(low, glm::vec2(-1.0f)), glm::vec2(0.0f));
    return 0.5f * 0.25f * size.x * size.y;
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
double DrawParts::shareOf(std::size_t cluster, const glm::dmat4& toEye, double scale) const {
    const double share = perArea_ * double{areas_[cluster]} * scale * scale;
    if (view_.orthographic) return share;
    const double distance = distanceTo(transformed(scene_.clusters[cluster].bounds, toEye));
    return share / std::max(distance * distance, 1e-30);
}

// Appends triangles or other primitives of the draw, in their order.
void DrawParts::append(std::uint32_t firstIndex, std::uint32_t indexCount, double fragments) {
    if (parts_.empty() || parts_.back().fragments + fragments > kMaxFragments) {
        parts_.push_back({firstIndex, 0, 0.0});
    }
    parts_.back().indexCount += indexCount;
    parts_.back().fragments += fragments;
}

// By the rectangle of each triangle.
void DrawParts::appendTriangles(const Draw& draw, std::uint32_t firstIndex, std::uint32_t end) {
    const Instance& instance = scene_.instances[draw.instance];
    const Mesh& mesh = scene_.meshes[instance.mesh];
    const DeformedMesh* deformed = nullptr;
    if (mesh.deformation != kNone && mesh.deformation < pose_.deformed.size()) {
        deformed = pose_.deformed[mesh.deformation].get();
    }
    const glm::mat4 clip(view_.clipFromView * view_.viewFromWorld *
                         pose_.worldFromNode[instance.node]);
    const auto corner = [&](std::uint32_t i) {
        const std::uint32_t vertex = scene_.indices[i];
        return clip * glm::vec4(deformed
                                    ? deformed->vertices[vertex - deformed->firstVertex].position
                                    : scene_.vertices[vertex].position,
                                1.0f);
    };
    for (std::uint32_t i = firstIndex; i + 2 < end; i += 3) {
        append(i, 3,
               pixels_ * shareOfTriangle({corner(i), corner(i + 1), corner(i + 2)}) + kPerTriangle);
    }
}

void DrawParts::appendClusters(const Draw& draw) {
    const Instance& instance = scene_.instances[draw.instance];
    const Mesh& mesh = scene_.meshes[instance.mesh];
    const glm::dmat4& world = pose_.worldFromNode[instance.node];
    const glm::dmat4 toEye = eyeFromLocal(view_, world);
    const double scale = largestScale(world);
    const auto begin = scene_.clusters.begin() + mesh.firstCluster,
               last = begin + mesh.clusterCount;
    auto at = std::partition_point(begin, last, [&](const Cluster& c) {
        return c.firstIndex + c.indexCount <= draw.firstIndex;
    });
    const std::uint32_t end = draw.firstIndex + draw.indexCount;
    for (; at != last && at->firstIndex < end; ++at) {
        const std::uint32_t first = std::max(draw.firstIndex, at->firstIndex),
                            next = std::min(end, at->firstIndex + at->indexCount);
        const double triangles = (next - first) / 3.0;
        const auto cluster = static_cast<std::size_t>(at - scene_.clusters.begin());
        const double fragments = pixels_ * std::min(triangles, shareOf(cluster, toEye, scale)) +
                                 triangles * kPerTriangle;
        if (fragments <= kFewFragments) {
            append(first, next - first, fragments);
        } else {
            appendTriangles(draw, first, next);
        }
    }
}

std::span<const DrawParts::Part> DrawParts::of(const Draw& draw) {
    parts_.clear();
    if (draw.primitive != Primitive::triangles) {
        const double width = std::max(double{draw.pointSize}, 1.0);
        const double length = draw.primitive == Primitive::lines ? 2.0 * std::sqrt(pixels_) : width;
        const std::uint32_t each = indicesPer(draw.primitive);
        const double fragments = std::min(pixels_, width * length) + kPerTriangle;
        for (std::uint32_t i = 0; i < draw.indexCount; i += each) {
            append(draw.firstIndex + i, each, fragments);
        }
    } else if (scene_.meshes[scene_.instances[draw.instance].mesh].deformation != kNone) {
        appendTriangles(draw, draw.firstIndex, draw.firstIndex + draw.indexCount);
    } else {
        appendClusters(draw);
    }
    return parts_;
}

}  // namespace clerestory
