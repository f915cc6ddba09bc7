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
constexpr int kMaxDepth = 24;

// A body is small below this multiple of the common length.
constexpr double kSmall = 8.0;
constexpr std::size_t kMaxSmall = 64;  // the largest of them
constexpr double kFlat = 0.01;         // thickness over the greatest extent of a flat light
// Length of edges relative to the size of the body: at least, and at most where it pays.
constexpr double kFinest = 0.05, kCoarsest = 0.4;
// Growth of the length with the distance from the body, in units of the length at the body.
constexpr double kGrowth = 5.0;

// Whether light is computed at the vertices of an instance of a mesh that is divided.
bool isDivided(const Scene& scene, const std::vector<bool>& moves, std::size_t i) {
    const Instance& instance = scene.instances[i];
    return !moves[i] && scene.meshes[instance.mesh].deformation == kNone &&
           !scene.materials[instance.material].unlit &&
           i != scene.ground;  // made with small triangles
}

// Where the instances of a mesh are, and the largest factor by which one lengthens an edge; 0 if no
// instance shows light.
struct Placement {
    struct Place {
        glm::dmat4 worldFromMesh{1.0};
        std::uint32_t instance = 0;
    };
    double scale = 0.0;
    std::vector<Place> places;
};

std::vector<Placement> placementsOf(const Scene& scene, const Pose& pose) {
    const std::vector<bool> moves = instancesThatMove(scene);
    std::vector<Placement> placements(scene.meshes.size());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (!isDivided(scene, moves, i)) continue;
        Placement& placement = placements[scene.instances[i].mesh];
        const glm::dmat4& m = pose.worldFromNode[scene.instances[i].node];
        for (int column = 0; column < 3; ++column) {
            placement.scale = std::max(placement.scale, glm::length(glm::dvec3(m[column])));
        }
        placement.places.push_back({m, static_cast<std::uint32_t>(i)});
    }
    // Copies share their triangles: what is divided near a small body is divided in all of them.
    constexpr std::size_t kMaxCopies = 4;
    for (Placement& placement : placements) {
        if (placement.places.size() > kMaxCopies) placement.places.clear();
    }
    return placements;
}

bool isTooLong(const EdgeLengths& edges, const Placement& placement, const glm::dvec3& a,
               const glm::dvec3& b) {
    const double length = placement.scale * glm::distance(a, b);
    if (length > edges.common) return true;
    if (edges.small.empty() || !(length > edges.perSize * edges.small.back().size)) return false;
    return std::any_of(placement.places.begin(), placement.places.end(), [&](const auto& place) {
        const glm::dvec3 middle(place.worldFromMesh * glm::dvec4(0.5 * (a + b), 1.0));
        return edges.below(length, middle, place.instance);
    });
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

struct Triangle {
    glm::dvec3 corners[3];  // of the mesh
    double longest = 0.0;   // edge, world
    const Placement* placement = nullptr;
};

std::vector<Triangle> trianglesOf(const Scene& scene, const std::vector<Placement>& placements) {
    std::vector<Triangle> triangles;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        const double scale = placements[m].scale;
        if (!(scale > 0.0) || mesh.primitive != Primitive::triangles) continue;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                Triangle t{.placement = &placements[m]};
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const std::uint32_t index = scene.indices[cluster.firstIndex + i + k];
                    t.corners[k] = glm::dvec3(scene.vertices[index].position);
                }
                for (int k = 0; k < 3; ++k) {
                    const double edge = glm::distance(t.corners[k], t.corners[(k + 1) % 3]);
                    t.longest = std::max(t.longest, scale * edge);
                }
                triangles.push_back(t);
            }
        }
    }
    return triangles;
}

// Triangles that one is divided into; somewhat more than `limit` if there would be more.
std::uint64_t countOfParts(const Triangle& t, const EdgeLengths& edges, std::uint64_t limit) {
    std::uint64_t count = 0;
    divide(
        t.corners[0], t.corners[1], t.corners[2],
        [&](const glm::dvec3& a, const glm::dvec3& b) {
            return count <= limit && isTooLong(edges, *t.placement, a, b);
        },
        [](const glm::dvec3& a, const glm::dvec3& b) { return 0.5 * (a + b); },
        [&](const auto&, const auto&, const auto&) { ++count; });
    return count;
}

// Triangles that are added; somewhat more than `limit` if there would be more.
std::uint64_t countOfAdded(const std::vector<Triangle>& triangles, const EdgeLengths& edges,
                           std::uint64_t limit) {
    double shortest = edges.common;
    if (!edges.small.empty()) {
        shortest = std::min(shortest, edges.perSize * edges.small.back().size);
    }
    std::uint64_t added = 0;
    for (const Triangle& t : triangles) {
        if (!(t.longest > shortest)) continue;
        added += countOfParts(t, edges, limit + 1 - added) - 1;
        if (added > limit) return added;
    }
    return added;
}

// The smallest value with which no more triangles than `limit` are added, and which is at least
// `low`; `high` if there is none. set: sets the value. steps: of the bisection.
template <class Set>
double smallestWithin(const std::vector<Triangle>& triangles, EdgeLengths edges, double low,
                      double high, std::uint64_t limit, int steps, const Set& set) {
    const auto isEnough = [&](double value) {
        set(edges, value);
        return countOfAdded(triangles, edges, limit) <= limit;
    };
    if (isEnough(low)) return low;
    for (int i = 0; i < steps; ++i) {
        const double middle = std::sqrt(low * high);
        (isEnough(middle) ? high : low) = middle;
    }
    return high;
}

// The part of a ceiling that a flat light covers is as bright as the light, and short triangles
// across the light's edge would show that. box: of the mesh.
bool isFlatEmitter(const Material& material, const Bounds& box, const glm::dmat4& worldFromMesh) {
    if (emittedRadiance(material) == glm::vec3(0.0f)) return false;
    glm::dvec3 extent(box.max - box.min);
    for (int k = 0; k < 3; ++k) extent[k] *= glm::length(glm::dvec3(worldFromMesh[k]));
    return std::min({extent.x, extent.y, extent.z}) <
           kFlat * std::max({extent.x, extent.y, extent.z});
}

// The largest first.
std::vector<EdgeLengths::Body> smallBodies(const Scene& scene, const Pose& pose, double common) {
    const std::vector<bool> moves = instancesThatMove(scene);
    std::vector<EdgeLengths::Body> bodies;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (!isDivided(scene, moves, i) || mesh.primitive != Primitive::triangles) continue;
        Bounds box;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            box.add(scene.clusters[mesh.firstCluster + c].bounds);
        }
        const glm::dmat4& worldFromMesh = pose.worldFromNode[instance.node];
        if (isFlatEmitter(scene.materials[instance.material], box, worldFromMesh)) continue;
        box = transformed(box, worldFromMesh);
        const double size = box.diagonal();
        if (size > 0.0 && size < kSmall * common) {
            bodies.push_back({box, size, static_cast<std::uint32_t>(i)});
        }
    }
    std::stable_sort(bodies.begin(), bodies.end(),
                     [](const auto& a, const auto& b) { return a.size > b.size; });
    if (bodies.size() > kMaxSmall) bodies.resize(kMaxSmall);
    return bodies;
}

EdgeLengths edgeLengthsFor(const Scene& scene, const Pose& pose,
                           const std::vector<Triangle>& triangles, const RefinementLimits& limits) {
    const double diagonal = lastingBounds(scene, pose).diagonal();
    const double shortest = limits.shortestEdge * diagonal;
    EdgeLengths edges;
    edges.common =
        smallestWithin(triangles, edges, shortest, std::max(shortest, diagonal),
                       limits.addedTriangles, 24, [](EdgeLengths& e, double v) { e.common = v; });
    const std::uint64_t limit =
        countOfAdded(triangles, edges, limits.addedTriangles) + limits.addedNearBodies;
    // The smaller half of the bodies is left out as long as there would be too many triangles.
    for (edges.small = smallBodies(scene, pose, edges.common); !edges.small.empty();
         edges.small.resize(edges.small.size() / 2)) {
        edges.perSize = smallestWithin(triangles, edges, kFinest, kCoarsest, limit, 8,
                                       [](EdgeLengths& e, double v) { e.perSize = v; });
        if (edges.perSize < kCoarsest) break;
    }
    return edges;
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
    Divider(std::vector<Vertex>& vertices, std::vector<std::uint32_t>& indices,
            const EdgeLengths& edges, const Placement& placement)
        : vertices_(vertices), indices_(indices), edges_(edges), placement_(placement) {}

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        divide(
            a, b, c,
            [this](std::uint32_t p, std::uint32_t q) {
                return placement_.scale > 0.0 &&
                       isTooLong(edges_, placement_, glm::dvec3(vertices_[p].position),
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

std::vector<VertexRange> vertexRanges(const Scene& scene) {
    std::vector<VertexRange> ranges;
    for (const Mesh& mesh : scene.meshes) ranges.push_back(vertexRange(scene, mesh));
    return ranges;
}

bool overlaps(std::vector<VertexRange> ranges) {
    std::sort(ranges.begin(), ranges.end(),
              [](const VertexRange& a, const VertexRange& b) { return a.first < b.first; });
    for (std::size_t i = 1; i < ranges.size(); ++i) {
        if (ranges[i - 1].first + ranges[i - 1].count > ranges[i].first) return true;
    }
    return false;
}

// The way from a box to a point outside; 0 inside.
glm::dvec3 outsideOf(const Bounds& box, const glm::dvec3& point) {
    return glm::max(glm::max(glm::dvec3(box.min) - point, point - glm::dvec3(box.max)),
                    glm::dvec3(0.0));
}

Scene withoutTexels(const Scene& scene) {
    Scene copy = scene;
    for (TextureImage& image : copy.images) std::vector<std::uint8_t>().swap(image.texels);
    return copy;
}

}  // namespace

double EdgeLengths::at(const glm::dvec3& world, std::uint32_t except) const {
    double length = common;
    for (const Body& body : small) {
        if (body.instance == except) continue;
        const double away = glm::length(outsideOf(body.box, world));
        length = std::min(length, perSize * (body.size + kGrowth * away));
    }
    return length;
}

bool EdgeLengths::below(double length, const glm::dvec3& world, std::uint32_t except) const {
    if (common < length) return true;
    return std::any_of(small.begin(), small.end(), [&](const Body& body) {
        if (body.instance == except) return false;
        const double reach = (length / perSize - body.size) / kGrowth;
        if (!(reach > 0.0)) return false;
        const glm::dvec3 away = outsideOf(body.box, world);
        return glm::dot(away, away) < reach * reach;
    });
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

Refined refined(const Scene& scene, const Pose& pose, const RefinementLimits& limits) {
    EdgeLengths edges;
    if (!overlaps(vertexRanges(scene))) {
        const std::vector<Placement> placements = placementsOf(scene, pose);
        edges = edgeLengthsFor(scene, pose, trianglesOf(scene, placements), limits);
    }
    Scene fine = refinedWith(edges, scene, pose);
    return {std::move(fine), std::move(edges)};
}

Scene refinedWith(const EdgeLengths& edges, const Scene& scene, const Pose& pose) {
    Scene fine = withoutTexels(scene);
    const std::vector<VertexRange> ranges = vertexRanges(scene);
    if (!(edges.common > 0.0) || overlaps(ranges)) return fine;

    const std::vector<Placement> placements = placementsOf(scene, pose);
    fine.vertices.clear();
    fine.indices.clear();
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        const VertexRange range = ranges[m];
        const auto first = static_cast<std::uint32_t>(fine.vertices.size());
        fine.vertices.insert(fine.vertices.end(), scene.vertices.begin() + range.first,
                             scene.vertices.begin() + range.first + range.count);
        if (mesh.deformation != kNone) fine.deformations[mesh.deformation].firstVertex = first;
        const bool surface = mesh.primitive == Primitive::triangles;
        Divider divider(fine.vertices, fine.indices, edges, placements[m]);
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
    return fine;
}

}  // namespace clerestory::light
