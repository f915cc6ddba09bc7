#include "light/division.h"

#include "scene/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace clerestory::light {
namespace {

glm::vec3 unitOr(const glm::vec3& v, const glm::vec3& other) {
    const float squared = glm::dot(v, v);
    return squared > 1e-12f ? v / std::sqrt(squared) : other;
}

Vertex middleOf(const Vertex& a, const Vertex& b) {
    return {
        .position = 0.5f * (a.position + b.position),
        .normal = unitOr(a.normal + b.normal, a.normal),
        .tangent = glm::vec4(
            unitOr(glm::vec3(a.tangent) + glm::vec3(b.tangent), glm::vec3(a.tangent)), a.tangent.w),
        .texCoord0 = 0.5f * (a.texCoord0 + b.texCoord0),
        .texCoord1 = 0.5f * (a.texCoord1 + b.texCoord1),
        .color = 0.5f * (a.color + b.color)};
}

// Divides the triangles of one mesh.
class Divider {
public:
    Divider(std::vector<Vertex>& vertices, std::vector<std::uint32_t>& indices,
            const EdgeLengths& edges, const Placement& placement)
        : vertices_(vertices), indices_(indices), edges_(edges), placement_(placement) {}

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        divide(
            a, b, c,
            [this](std::uint32_t p, std::uint32_t q) {
                return isTooLong(edges_, placement_, glm::dvec3(vertices_[p].position),
                                 glm::dvec3(vertices_[q].position));
            },
            [this](std::uint32_t p, std::uint32_t q) { return middle(p, q); },
            [this](std::uint32_t p, std::uint32_t q, std::uint32_t r) {
                indices_.insert(indices_.end(), {p, q, r});
            });
    }

private:
    std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
        const auto [it, isNew] =
            middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices_.size()));
        if (isNew) {
            const Vertex made = middleOf(vertices_[it->first.first], vertices_[it->first.second]);
            vertices_.push_back(made);
        }
        return it->second;
    }

    std::vector<Vertex>& vertices_;
    std::vector<std::uint32_t>& indices_;
    const EdgeLengths& edges_;
    const Placement& placement_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

Scene withoutTexels(const Scene& scene) {
    Scene copy = scene;
    for (TextureImage& image : copy.images) std::vector<std::uint8_t>().swap(image.texels);
    return copy;
}

bool isAnyTooLong(const EdgeLengths& edges, const Scene& scene, const Placement& placement) {
    bool any = false;
    eachTriangle(scene, scene.meshes[placement.mesh], [&](const std::uint32_t* corners) {
        for (int k = 0; k < 3 && !any; ++k) {
            any = isTooLong(edges, placement, glm::dvec3(scene.vertices[corners[k]].position),
                            glm::dvec3(scene.vertices[corners[(k + 1) % 3]].position));
        }
    });
    return any;
}

// With clusters and flat parts of its own, which are still those of the original.
Index addCopyOfMesh(Scene& scene, Index original) {
    const auto copy = static_cast<Index>(scene.meshes.size());
    Mesh mesh = scene.meshes[original];
    const auto clusters = static_cast<std::uint32_t>(scene.clusters.size());
    const auto parts = static_cast<std::uint32_t>(scene.flatParts.size());
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster cluster = scene.clusters[mesh.firstCluster + c];
        scene.clusters.push_back(cluster);
    }
    for (std::uint32_t p = 0; p < mesh.flatPartCount; ++p) {
        FlatPart part = scene.flatParts[mesh.firstFlatPart + p];
        part.firstCluster += clusters - mesh.firstCluster;
        scene.flatParts.push_back(part);
    }
    mesh.firstCluster = clusters;
    mesh.firstFlatPart = parts;
    scene.meshes.push_back(std::move(mesh));
    for (Variant& variant : scene.variants) {
        const auto chosen = std::find_if(variant.choices.begin(), variant.choices.end(),
                                         [&](const auto& c) { return c.mesh == original; });
        if (chosen != variant.choices.end()) variant.choices.push_back({copy, chosen->material});
    }
    return copy;
}

// Gives a mesh the divided triangles of an original, or those that it has without a placement.
void divideMesh(const EdgeLengths& edges, const Scene& scene, const Placement* placement,
                Index original, Index mesh, Scene& fine) {
    const Mesh& coarse = scene.meshes[original];
    const VertexRange range = vertexRange(scene, coarse);
    const auto first = static_cast<std::uint32_t>(fine.vertices.size());
    fine.vertices.insert(fine.vertices.end(), scene.vertices.begin() + range.first,
                         scene.vertices.begin() + range.first + range.count);
    if (coarse.deformation != kNone) fine.deformations[coarse.deformation].firstVertex = first;
    std::optional<Divider> divider;
    if (placement) divider.emplace(fine.vertices, fine.indices, edges, *placement);
    std::uint32_t primitives = 0;
    for (std::uint32_t c = 0; c < coarse.clusterCount; ++c) {
        const Cluster& from = scene.clusters[coarse.firstCluster + c];
        Cluster& cluster = fine.clusters[fine.meshes[mesh].firstCluster + c];
        cluster.firstIndex = static_cast<std::uint32_t>(fine.indices.size());
        const std::uint32_t* corner = &scene.indices[from.firstIndex];
        const std::uint32_t* const end = corner + from.indexCount;
        for (; divider && corner != end; corner += 3) {
            divider->add(corner[0] - range.first + first, corner[1] - range.first + first,
                         corner[2] - range.first + first);
        }
        for (; corner != end; ++corner) fine.indices.push_back(*corner - range.first + first);
        cluster.indexCount = static_cast<std::uint32_t>(fine.indices.size()) - cluster.firstIndex;
        primitives += cluster.indexCount / indicesPer(coarse.primitive);
    }
    endTriple(fine.indices);
    fine.meshes[mesh].primitives = primitives;
}

}  // namespace

bool isTooLong(const EdgeLengths& edges, const Placement& placement, const glm::dvec3& a,
               const glm::dvec3& b) {
    const double length = placement.lengthOf(a, b);
    if (length > edges.common) return true;
    if (edges.small.empty() || !(length > edges.perSize * edges.small.back().size)) return false;
    return std::any_of(placement.places.begin(), placement.places.end(), [&](const auto& place) {
        const glm::dvec3 middle(place.worldFromMesh * glm::dvec4(0.5 * (a + b), 1.0));
        return edges.below(length, middle, place.instance);
    });
}

bool sharesVertices(const Scene& scene) {
    std::vector<VertexRange> ranges;
    for (const Mesh& mesh : scene.meshes) ranges.push_back(vertexRange(scene, mesh));
    std::sort(ranges.begin(), ranges.end(),
              [](const VertexRange& a, const VertexRange& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < ranges.size(); ++i) {
        if (ranges[i - 1].first + ranges[i - 1].count > ranges[i].first) return true;
    }
    return false;
}

VertexRange vertexRange(const Scene& scene, const Mesh& mesh) {
    if (mesh.deformation != kNone) {
        const Deformation& deformation = scene.deformations[mesh.deformation];
        return {deformation.firstVertex, static_cast<std::uint32_t>(deformation.base.size())};
    }
    std::uint32_t low = std::numeric_limits<std::uint32_t>::max(), high = 0;
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
        for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
            low = std::min(low, scene.indices[cluster.firstIndex + i]);
            high = std::max(high, scene.indices[cluster.firstIndex + i] + 1);
        }
    }
    return low < high ? VertexRange{low, high - low} : VertexRange{};
}

Scene refinedWith(const EdgeLengths& edges, const Scene& scene, const Pose& pose) {
    Scene fine = withoutTexels(scene);
    if (!(edges.common > 0.0) || sharesVertices(scene)) return fine;
    fine.vertices.clear();
    fine.indices.clear();
    const std::vector<Placement> placements = placementsOf(scene, pose, edges);
    auto next = placements.begin();
    for (Index m = 0; m < scene.meshes.size(); ++m) {
        std::vector<const Placement*> divided;
        bool all = true;
        for (; next != placements.end() && next->mesh == m; ++next) {
            if (isAnyTooLong(edges, scene, *next)) {
                divided.push_back(&*next);
            } else {
                all = false;
            }
        }
        // The mesh itself is for instances of which nothing is divided; if there are none, for the
        // first placement. Each other placement has a copy.
        const std::size_t first = all && !divided.empty() ? 1 : 0;
        divideMesh(edges, scene, first > 0 ? divided[0] : nullptr, m, m, fine);
        for (std::size_t k = first; k < divided.size(); ++k) {
            const Index copy = addCopyOfMesh(fine, m);
            divideMesh(edges, scene, divided[k], m, copy, fine);
            for (const std::uint32_t i : divided[k]->instances) fine.instances[i].mesh = copy;
        }
    }
    return fine;
}

}  // namespace clerestory::light
