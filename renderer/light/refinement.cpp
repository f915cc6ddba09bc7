#include "light/refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace clerestory::light {
namespace {

// Halvings of an edge: bounds the work for triangles of extreme size.
constexpr int kMaxDepth = 9;
// Area of a triangle of the mesh that results, over the square of the longest edge allowed.
constexpr double kAreaOfEdge = 0.3;

// Largest factor by which an instance of the mesh lengthens an edge; 0 if no instance shows light.
std::vector<double> scalesOf(const Scene& scene, const Pose& pose) {
    const std::vector<bool> moves = instancesThatMove(scene);
    std::vector<double> scales(scene.meshes.size(), 0.0);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (moves[i] || scene.meshes[instance.mesh].deformation != kNone) continue;
        if (scene.materials[instance.material].unlit) continue;
        const glm::dmat4& m = pose.worldFromNode[instance.node];
        for (int column = 0; column < 3; ++column) {
            scales[instance.mesh] =
                std::max(scales[instance.mesh], glm::length(glm::dvec3(m[column])));
        }
    }
    return scales;
}

double edge(const Vertex& a, const Vertex& b) {
    return glm::length(glm::dvec3(a.position) - glm::dvec3(b.position));
}

// A triangle of the scene in the world: its longest edge and its area.
struct Size {
    double edge, area;
};

std::vector<Size> sizesOf(const Scene& scene, const std::vector<double>& scales) {
    std::vector<Size> sizes;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        if (!(scales[m] > 0.0)) continue;
        const Mesh& mesh = scene.meshes[m];
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                const std::uint32_t* corner = &scene.indices[cluster.firstIndex + i];
                const Vertex &p = scene.vertices[corner[0]], &q = scene.vertices[corner[1]],
                             &r = scene.vertices[corner[2]];
                const glm::dvec3 x = glm::dvec3(q.position) - glm::dvec3(p.position),
                                 y = glm::dvec3(r.position) - glm::dvec3(p.position);
                sizes.push_back({scales[m] * std::max({edge(p, q), edge(q, r), edge(r, p)}),
                                 scales[m] * scales[m] * 0.5 * glm::length(glm::cross(x, y))});
            }
        }
    }
    return sizes;
}

// The longest edge in the world with which about so many triangles are added.
double edgeFor(const std::vector<Size>& sizes, double shortest, double diagonal,
               std::uint64_t addedTriangles) {
    const auto added = [&](double length) {
        double sum = 0.0;
        for (const Size& size : sizes) {
            if (size.edge > length) sum += size.area / (kAreaOfEdge * length * length) + 1.0;
        }
        return sum;
    };
    double low = shortest, high = std::max(shortest, diagonal);
    if (added(low) <= static_cast<double>(addedTriangles)) return low;
    for (int i = 0; i < 40; ++i) {
        const double middle = std::sqrt(low * high);
        (added(middle) <= static_cast<double>(addedTriangles) ? high : low) = middle;
    }
    return high;
}

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
    Divider(std::vector<Vertex>& vertices, std::vector<std::uint32_t>& indices, double longest)
        : vertices_(vertices), indices_(indices), longest_(longest) {}

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, int depth = 0) {
        if (depth < kMaxDepth) {
            const bool ab = tooLong(a, b), bc = tooLong(b, c), ca = tooLong(c, a);
            // Turned so that the first case of each number of long edges applies.
            if (ab && bc && ca) {
                const std::uint32_t x = middle(a, b), y = middle(b, c), z = middle(c, a);
                add(a, x, z, depth + 1);
                add(x, b, y, depth + 1);
                add(z, y, c, depth + 1);
                return add(x, y, z, depth + 1);
            }
            if (ab && bc) return addTwo(a, b, c, depth);
            if (bc && ca) return addTwo(b, c, a, depth);
            if (ca && ab) return addTwo(c, a, b, depth);
            if (ab) return addOne(a, b, c, depth);
            if (bc) return addOne(b, c, a, depth);
            if (ca) return addOne(c, a, b, depth);
        }
        indices_.insert(indices_.end(), {a, b, c});
    }

private:
    bool tooLong(std::uint32_t a, std::uint32_t b) const {
        return edge(vertices_[a], vertices_[b]) > longest_;
    }
    std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
        const auto [it, isNew] =
            middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices_.size()));
        if (isNew) {
            const Vertex made = middleOf(vertices_[it->first.first], vertices_[it->first.second]);
            vertices_.push_back(made);
        }
        return it->second;
    }
    void addOne(std::uint32_t a, std::uint32_t b, std::uint32_t c, int depth) {
        const std::uint32_t x = middle(a, b);
        add(a, x, c, depth + 1);
        add(x, b, c, depth + 1);
    }
    // Edges a b and b c are long.
    void addTwo(std::uint32_t a, std::uint32_t b, std::uint32_t c, int depth) {
        const std::uint32_t x = middle(a, b), y = middle(b, c);
        add(x, b, y, depth + 1);
        add(a, x, c, depth + 1);
        add(x, y, c, depth + 1);
    }

    std::vector<Vertex>& vertices_;
    std::vector<std::uint32_t>& indices_;
    double longest_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

bool overlaps(std::vector<VertexRange> ranges) {
    std::sort(ranges.begin(), ranges.end(),
              [](const VertexRange& a, const VertexRange& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < ranges.size(); ++i) {
        if (ranges[i - 1].first + ranges[i - 1].count > ranges[i].first) return true;
    }
    return false;
}

Scene withoutTexels(const Scene& scene) {
    Scene copy = scene;
    for (TextureImage& image : copy.images) std::vector<std::uint8_t>().swap(image.texels);
    return copy;
}

}  // namespace

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

Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits) {
    Scene fine = withoutTexels(scene);
    std::vector<VertexRange> ranges;
    for (const Mesh& mesh : scene.meshes) ranges.push_back(vertexRange(scene, mesh));
    if (overlaps(ranges)) return {std::move(fine)};

    const std::vector<double> scales = scalesOf(scene, pose);
    const double diagonal = lastingBounds(scene, pose).diagonal();
    const double longest = edgeFor(sizesOf(scene, scales), limits.shortestEdge * diagonal, diagonal,
                                   limits.addedTriangles);
    fine.vertices.clear();
    fine.indices.clear();
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        const VertexRange range = ranges[m];
        const auto first = static_cast<std::uint32_t>(fine.vertices.size());
        fine.vertices.insert(fine.vertices.end(), scene.vertices.begin() + range.first,
                             scene.vertices.begin() + range.first + range.count);
        if (mesh.deformation != kNone) fine.deformations[mesh.deformation].firstVertex = first;
        const double local =
            scales[m] > 0.0 ? longest / scales[m] : std::numeric_limits<double>::infinity();
        Divider divider(fine.vertices, fine.indices, local);
        std::uint32_t triangles = 0;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& coarse = scene.clusters[mesh.firstCluster + c];
            Cluster& cluster = fine.clusters[mesh.firstCluster + c];
            cluster.firstIndex = static_cast<std::uint32_t>(fine.indices.size());
            for (std::uint32_t i = 0; i < coarse.indexCount; i += 3) {
                const std::uint32_t* corner = &scene.indices[coarse.firstIndex + i];
                divider.add(corner[0] - range.first + first, corner[1] - range.first + first,
                            corner[2] - range.first + first);
            }
            cluster.indexCount =
                static_cast<std::uint32_t>(fine.indices.size()) - cluster.firstIndex;
            triangles += cluster.indexCount / 3;
        }
        fine.meshes[m].triangles = triangles;
    }
    return {std::move(fine), longest};
}

}  // namespace clerestory::light
