#include "light/places.h"

#include "light/division.h"
#include "light/surface_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

namespace clerestory::light {
namespace {

// Two points may share a place above this cosine of their normals, and below this distance from
// each other's plane, relative to the distance between places.
constexpr float kSameNormal = 0.9f, kSamePlane = 0.2f;
// The same of a place that a point takes a part of its light from.
constexpr float kMinNormal = 0.6f, kMaxOutOfPlane = 0.35f;
// Relative to the distance of places: within it a point has no place of its own; to it places
// count.
constexpr float kShared = 0.6f, kReach = 1.25f;
constexpr std::size_t kMaxParts = 12;
// Offset of the start of rays from a point, relative to the mean of the vectors to the centres of
// its triangles: 0 within a regular mesh.
constexpr float kInwards = 0.25f;

struct PointKey {
    std::uint32_t bits[7] = {};
    bool operator==(const PointKey&) const = default;
};
struct PointHash {
    std::size_t operator()(const PointKey& key) const {
        std::uint64_t h = 1469598103934665603ull;
        for (const std::uint32_t b : key.bits) h = (h ^ b) * 1099511628211ull;
        return static_cast<std::size_t>(h ^ (h >> 29));
    }
};

// Sums over the triangles of a point.
struct TrianglesAround {
    glm::vec3 ways{0.0f};    // to their centres
    glm::vec3 normal{0.0f};  // weighted by area, not unit
    float count = 0.0f;
};

void addTriangles(const PlacesInput& input, std::size_t i, const Places& places,
                  std::vector<TrianglesAround>& around) {
    const Scene& scene = input.scene;
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const std::int32_t first = places.firstOfInstance[i];
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
        for (std::uint32_t k = 0; k < cluster.indexCount; k += 3) {
            std::uint32_t corner[3];
            glm::vec3 centre(0.0f);
            for (std::uint32_t j = 0; j < 3; ++j) {
                const auto vertex =
                    static_cast<std::int32_t>(scene.indices[cluster.firstIndex + k + j]);
                corner[j] = places.pointOf[static_cast<std::size_t>(first + vertex)];
                centre += places.points[corner[j]].position / 3.0f;
            }
            const glm::vec3& a = places.points[corner[0]].position;
            const glm::vec3 normal = glm::cross(places.points[corner[1]].position - a,
                                                places.points[corner[2]].position - a);
            for (const std::uint32_t point : corner) {
                around[point].ways += centre - places.points[point].position;
                around[point].normal += normal;
                around[point].count += 1.0f;
            }
        }
    }
}

void setStarts(const PlacesInput& input, Places& places) {
    std::vector<TrianglesAround> around(places.points.size());
    for (std::size_t i = 0; i < places.firstOfInstance.size(); ++i) {
        if (places.firstOfInstance[i] != kNoLight) addTriangles(input, i, places, around);
    }
    for (std::size_t i = 0; i < places.points.size(); ++i) {
        Receiver& point = places.points[i];
        const glm::vec3 way = around[i].ways / std::max(around[i].count, 1.0f);
        // Not the point's own normal: smooth normals of a coarse mesh lean out of its faces, and
        // across them lies the inside of a body.
        const float length = glm::length(around[i].normal);
        const glm::vec3 normal = length > 0.0f ? around[i].normal / length : glm::vec3(0.0f);
        const glm::vec3 along = way - glm::dot(way, normal) * normal;
        point.start = point.position + kInwards * along;
    }
}

void collectPoints(const PlacesInput& input, Places& places) {
    const Scene& scene = input.scene;
    const std::vector<bool> moves = instancesThatMove(scene);
    std::unordered_map<PointKey, std::uint32_t, PointHash> found;
    places.firstOfInstance.assign(scene.instances.size(), kNoLight);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Material& material = input.materials.material(
            scene, input.materials.materialOf(scene, static_cast<Index>(i)));
        if (moves[i] || mesh.deformation != kNone || material.unlit ||
            mesh.primitive != Primitive::triangles) {
            continue;
        }
        const VertexRange range = vertexRange(scene, mesh);
        places.firstOfInstance[i] = static_cast<std::int32_t>(places.pointOf.size()) -
                                    static_cast<std::int32_t>(range.first);
        const glm::dmat4& world = input.pose.worldFromNode[instance.node];
        const glm::dmat3 normals = input.mapFromWorld * normalMatrix(glm::dmat3(world));
        for (std::uint32_t v = range.first; v < range.first + range.count; ++v) {
            const Vertex& vertex = scene.vertices[v];
            Receiver point;
            point.position = glm::vec3(
                glm::dvec3(world * glm::dvec4(glm::dvec3(vertex.position), 1.0)) - input.origin);
            const glm::dvec3 n = normals * glm::dvec3(vertex.normal);
            const double length = glm::length(n);
            point.normal = length > 0.0 ? glm::vec3(n / length) : glm::vec3(0.0f, 1.0f, 0.0f);
            point.twoSided = material.doubleSided;
            PointKey key;
            std::memcpy(key.bits, &point.position, 12);
            std::memcpy(key.bits + 3, &point.normal, 12);
            key.bits[6] = point.twoSided ? 1u : 0u;
            const auto [it, isNew] =
                found.try_emplace(key, static_cast<std::uint32_t>(places.points.size()));
            if (isNew) places.points.push_back(point);
            places.pointOf.push_back(it->second);
        }
    }
}

// Places by cells of a grid.
class Grid {
public:
    Grid(const std::vector<Receiver>& points, float cell) : points_(points), cell_(cell) {}

    void add(std::uint32_t place, std::uint32_t point) {
        cells_[keyOf(cellOf(points_[point].position))].push_back({place, point});
    }
    // visit(place, point) for all in the point's cell and the 26 around it, until it returns false.
    template <class Visit>
    void around(const glm::vec3& position, Visit visit) const {
        const glm::ivec3 middle = cellOf(position);
        for (int x = -1; x <= 1; ++x) {
            for (int y = -1; y <= 1; ++y) {
                for (int z = -1; z <= 1; ++z) {
                    const auto cell = cells_.find(keyOf(middle + glm::ivec3(x, y, z)));
                    if (cell == cells_.end()) continue;
                    for (const auto& [place, point] : cell->second) {
                        if (!visit(place, point)) return;
                    }
                }
            }
        }
    }

private:
    glm::ivec3 cellOf(const glm::vec3& p) const {
        return glm::ivec3(glm::clamp(glm::floor(p / cell_), -1e9f, 1e9f));
    }
    static std::uint64_t keyOf(const glm::ivec3& c) {
        return static_cast<std::uint32_t>(c.x) * 0x9e3779b97f4a7c15ull ^
               static_cast<std::uint32_t>(c.y) * 0xc2b2ae3d27d4eb4full ^
               static_cast<std::uint32_t>(c.z) * 0x165667b19e3779f9ull;
    }

    struct Entry {
        std::uint32_t place, point;
    };
    const std::vector<Receiver>& points_;
    float cell_;
    std::unordered_map<std::uint64_t, std::vector<Entry>> cells_;
};

// Whether points are on one surface.
class Neighbours {
public:
    Neighbours(const PlacesInput& input, const std::vector<Receiver>& points)
        : input_(input), points_(points), clearances_(points.size(), kUnknown) {}

    // Neither is further than `most` from the plane of the other, nor above a surface that covers
    // it. Among points of two sides, or at a great distance from each other, only the former
    // counts.
    bool onOneSurface(std::uint32_t a, std::uint32_t b, float distance, float most) {
        const glm::vec3 way(input_.mapFromWorld *
                            glm::dvec3(points_[b].position - points_[a].position));
        const float aboveA = glm::dot(way, points_[a].normal);
        const float aboveB = -glm::dot(way, points_[b].normal);
        if (std::max(std::abs(aboveA), std::abs(aboveB)) >= most * distance) return false;
        if (distance > kFar * input_.distance || points_[a].twoSided) return true;
        return isUncovered(a, aboveA, distance) && isUncovered(b, aboveB, distance);
    }

private:
    static constexpr float kUnknown = -1.0f, kFlat = 1e-4f, kFar = 4.0f;

    // 0.95: heights are rounded, and what lies on the covering surface is not below it.
    bool isUncovered(std::uint32_t point, float height, float distance) {
        if (height <= kFlat * distance) return true;
        float& clearance = clearances_[point];
        if (clearance == kUnknown) clearance = input_.clearanceAbove(points_[point]);
        return height < 0.95f * clearance;
    }

    const PlacesInput& input_;
    const std::vector<Receiver>& points_;
    std::vector<float> clearances_;
};

// Fills in `chosen`. distances: of places around each point. Returns false if there are more than
// the limit.
bool choose(const PlacesInput& input, const std::vector<float>& distances, Neighbours& neighbours,
            Places& places, Grid& grid) {
    places.chosen.clear();
    for (std::uint32_t i = 0; i < places.points.size(); ++i) {
        const Receiver& point = places.points[i];
        bool shared = false;
        grid.around(point.position, [&](std::uint32_t, std::uint32_t other) {
            const Receiver& o = places.points[other];
            const float distance = std::min(distances[i], distances[other]);
            shared = o.twoSided == point.twoSided &&
                     glm::dot(o.normal, point.normal) > kSameNormal &&
                     glm::length(o.position - point.position) < kShared * distance &&
                     neighbours.onOneSurface(other, i, distance, kSamePlane);
            return !shared;
        });
        if (shared) continue;
        if (places.chosen.size() >= input.limit) return false;
        grid.add(static_cast<std::uint32_t>(places.chosen.size()), i);
        places.chosen.push_back(i);
    }
    return true;
}

void weigh(const std::vector<float>& distances, const Grid& grid, Neighbours& neighbours,
           Places& places) {
    places.firstPart.assign(1, 0);
    std::vector<Places::Part> found;
    for (std::uint32_t i = 0; i < places.points.size(); ++i) {
        const Receiver& point = places.points[i];
        const float distance = distances[i];
        found.clear();
        grid.around(point.position, [&](std::uint32_t place, std::uint32_t other) {
            const Receiver& o = places.points[other];
            const float along = glm::length(o.position - point.position) / (kReach * distance);
            const float facing = glm::dot(o.normal, point.normal);
            if (along < 1.0f && facing > kMinNormal && o.twoSided == point.twoSided &&
                neighbours.onOneSurface(other, i, distance, kMaxOutOfPlane)) {
                const float near = 1.0f - along;
                found.push_back({place, near * near * (facing - kMinNormal) + 1e-6f});
            }
            return true;
        });
        // The order of cells does not matter, and the heaviest parts are enough.
        std::sort(found.begin(), found.end(), [](const Places::Part& a, const Places::Part& b) {
            return a.weight != b.weight ? a.weight > b.weight : a.place < b.place;
        });
        if (found.size() > kMaxParts) found.resize(kMaxParts);
        places.parts.insert(places.parts.end(), found.begin(), found.end());
        places.firstPart.push_back(static_cast<std::uint32_t>(places.parts.size()));
    }
}

}  // namespace

Places placesOf(const PlacesInput& input) {
    Places places;
    collectPoints(input, places);
    setStarts(input, places);
    Neighbours neighbours(input, places.points);
    auto distance = static_cast<float>(std::max(input.distance, 1e-9));
    std::vector<float> distances(places.points.size(), distance);
    for (std::size_t i = 0; input.distanceAt && i < distances.size(); ++i) {
        const glm::dvec3 world = glm::dvec3(places.points[i].position) + input.origin;
        distances[i] = std::min(distance, static_cast<float>(input.distanceAt(world)));
    }
    for (;; distance *= 1.3f) {
        Grid grid(places.points, kReach * distance);
        if (choose(input, distances, neighbours, places, grid)) {
            weigh(distances, grid, neighbours, places);
            places.distance = distance;
            for (const float d : distances) {
                places.areas.push_back(d / distance * (d / distance));
            }
            return places;
        }
        for (float& d : distances) d *= 1.3f;
    }
}

}  // namespace clerestory::light
