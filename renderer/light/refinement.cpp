#include "light/refinement.h"

#include "scene/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace clerestory::light {
namespace {

// Halvings of an edge: bounds the work for triangles of extreme size.
constexpr int kMaxDepth = 9;

// Largest factor by which an instance of the mesh lengthens an edge; 0 if no instance shows light.
std::vector<double> scalesOf(const Scene& scene, const Pose& pose) {
    const std::vector<bool> moves = instancesThatMove(scene);
    std::vector<double> scales(scene.meshes.size(), 0.0);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (moves[i] || scene.meshes[instance.mesh].deformation != kNone) continue;
        if (scene.materials[instance.material].unlit) continue;
        if (i == scene.ground) continue;  // made with small triangles
        const glm::dmat4& m = pose.worldFromNode[instance.node];
        for (int column = 0; column < 3; ++column) {
            scales[instance.mesh] =
                std::max(scales[instance.mesh], glm::length(glm::dvec3(m[column])));
        }
    }
    return scales;
}

// Halves edges for which tooLong(a, b) until none is left, and passes the triangles that result to
// add(a, b, c). Corners may be anything that middle(a, b) is made for.
template <class Corner, class TooLong, class Middle, class Add>
void divide(const Corner& a, const Corner& b, const Corner& c, const TooLong& tooLong,
            const Middle& middle, const Add& add, int depth = 0) {
    const auto further = [&](const Corner& p, const Corner& q, const Corner& r) {
        divide(p, q, r, tooLong, middle, add, depth + 1);
    };
    // The edge p q, or p q and q r.
    const auto one = [&](const Corner& p, const Corner& q, const Corner& r) {
        const Corner x = middle(p, q);
        further(p, x, r);
        further(x, q, r);
    };
    const auto two = [&](const Corner& p, const Corner& q, const Corner& r) {
        const Corner x = middle(p, q), y = middle(q, r);
        further(x, q, y);
        further(p, x, r);
        further(x, y, r);
    };
    const bool ab = depth < kMaxDepth && tooLong(a, b), bc = depth < kMaxDepth && tooLong(b, c),
               ca = depth < kMaxDepth && tooLong(c, a);
    if (ab && bc && ca) {
        const Corner x = middle(a, b), y = middle(b, c), z = middle(c, a);
        further(a, x, z);
        further(x, b, y);
        further(z, y, c);
        further(x, y, z);
    } else if (ab && bc) {
        two(a, b, c);
    } else if (bc && ca) {
        two(b, c, a);
    } else if (ca && ab) {
        two(c, a, b);
    } else if (ab) {
        one(a, b, c);
    } else if (bc) {
        one(b, c, a);
    } else if (ca) {
        one(c, a, b);
    } else {
        add(a, b, c);
    }
}

// A triangle of the scene with its size in the world.
struct Sized {
    glm::dvec3 corners[3];
    double longest = 0.0;  // edge
};

std::vector<Sized> trianglesOf(const Scene& scene, const std::vector<double>& scales) {
    std::vector<Sized> triangles;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        if (!(scales[m] > 0.0) || mesh.primitive != Primitive::triangles) continue;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                Sized t;
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const std::uint32_t index = scene.indices[cluster.firstIndex + i + k];
                    t.corners[k] = scales[m] * glm::dvec3(scene.vertices[index].position);
                }
                for (int k = 0; k < 3; ++k) {
                    t.longest =
                        std::max(t.longest, glm::distance(t.corners[k], t.corners[(k + 1) % 3]));
                }
                triangles.push_back(t);
            }
        }
    }
    return triangles;
}

// Triangles that one is divided into; somewhat more than `limit` if there would be more.
std::uint64_t countOfParts(const Sized& t, double longest, std::uint64_t limit) {
    std::uint64_t count = 0;
    divide(
        t.corners[0], t.corners[1], t.corners[2],
        [&](const glm::dvec3& a, const glm::dvec3& b) {
            return count <= limit && glm::distance(a, b) > longest;
        },
        [](const glm::dvec3& a, const glm::dvec3& b) { return 0.5 * (a + b); },
        [&](const auto&, const auto&, const auto&) { ++count; });
    return count;
}

// The shortest length of an edge in the world with which no more triangles are added.
double edgeFor(const std::vector<Sized>& triangles, double shortest, double diagonal,
               std::uint64_t addedTriangles) {
    const auto isEnough = [&](double length) {
        std::uint64_t added = 0;
        for (const Sized& t : triangles) {
            if (!(t.longest > length)) continue;
            added += countOfParts(t, length, addedTriangles + 1 - added) - 1;
            if (added > addedTriangles) return false;
        }
        return true;
    };
    double low = shortest, high = std::max(shortest, diagonal);
    if (isEnough(low)) return low;
    for (int i = 0; i < 24; ++i) {
        const double middle = std::sqrt(low * high);
        (isEnough(middle) ? high : low) = middle;
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

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        divide(
            a, b, c,
            [this](std::uint32_t p, std::uint32_t q) {
                return glm::distance(glm::dvec3(vertices_[p].position),
                                     glm::dvec3(vertices_[q].position)) > longest_;
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
    const double longest = edgeFor(trianglesOf(scene, scales), limits.shortestEdge * diagonal,
                                   diagonal, limits.addedTriangles);
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
        const bool surface = mesh.primitive == Primitive::triangles;
        Divider divider(fine.vertices, fine.indices, local);
        std::uint32_t primitives = 0;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& coarse = scene.clusters[mesh.firstCluster + c];
            Cluster& cluster = fine.clusters[mesh.firstCluster + c];
            cluster.firstIndex = static_cast<std::uint32_t>(fine.indices.size());
            const std::uint32_t* corner = &scene.indices[coarse.firstIndex];
            const std::uint32_t* const end = corner + coarse.indexCount;
            for (; surface && corner != end; corner += 3) {
                divider.add(corner[0] - range.first + first, corner[1] - range.first + first,
                            corner[2] - range.first + first);
            }
            for (; corner != end; ++corner) {
                fine.indices.push_back(*corner - range.first + first);
            }
            cluster.indexCount =
                static_cast<std::uint32_t>(fine.indices.size()) - cluster.firstIndex;
            primitives += cluster.indexCount / indicesPer(mesh.primitive);
        }
        endTriple(fine.indices);
        fine.meshes[m].primitives = primitives;
    }
    return {std::move(fine), longest};
}

}  // namespace clerestory::light
