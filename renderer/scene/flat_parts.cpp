// A histogram of normal direction and offset, weighted by area, gives candidates: from the largest
// triangle of the fullest bin a plane is fitted repeatedly to all triangles in it. Positions are
// relative to the mesh's centre, in a unit between half its diagonal and its diagonal.
#include "scene/mesh_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace clerestory {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kFlatness = 1e-4;  // of the group's diagonal
constexpr double kSameDirection = 1.0 * kDegree;
constexpr double kMinAspect = 1e-6;      // smaller extent over larger: below it is a line
constexpr double kCoarse = 4e-3;         // tolerance for a plane that is not yet fitted
constexpr float kCoarseCosine = 0.003f;  // about 3.4 degrees more than kSameDirection
// Vertex normals within kMinLean belong to the plane; beyond kMaxLean they are smoothed over an
// edge.
constexpr double kMinLean = 1.0 * kDegree, kMaxLean = 33.0 * kDegree;
constexpr int kMaxAttempts = 48;
constexpr int kMaxRounds = 8;

// Directions in 64 x 64 cells of an octahedron (about 2 degrees), offsets in 512 steps.
constexpr int kCells = 64, kSteps = 512;

std::uint32_t binOf(const glm::dvec3& n, double offset) {
    const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    double u = n.x / sum, v = n.y / sum;
    if (n.z < 0.0) {
        const double folded = (1.0 - std::abs(v)) * (u < 0.0 ? -1.0 : 1.0);
        v = (1.0 - std::abs(u)) * (v < 0.0 ? -1.0 : 1.0);
        u = folded;
    }
    const auto cell = [](double value, int count) {
        return static_cast<std::uint32_t>(
            std::clamp(static_cast<int>(value * count), 0, count - 1));
    };
    return (cell(0.5 + 0.5 * u, kCells) * kCells + cell(0.5 + 0.5 * v, kCells)) * kSteps +
           cell(0.5 + 0.5 * offset, kSteps);
}

// Slightly below the cosine, to allow for rounding. A series up to 0.1 radians, the common case,
// where the next term is below 2e-9.
float leastCosine(double angle) {
    constexpr double kRounding = 1e-7, kWidest = 80.0 * kDegree;
    const double squared = angle * angle;
    return static_cast<float>((angle < 0.1 ? 1.0 - squared / 2.0 + squared * squared / 24.0
                                           : std::cos(std::min(angle, kWidest))) -
                              kRounding);
}

class Finder {
public:
    Finder(std::span<const Vertex> vertices,
           std::span<const std::array<std::uint32_t, 3>> triangles)
        : vertices_(vertices), triangles_(triangles) {}

    std::vector<FlatGroup> run() {
        measure();
        binTriangles();
        std::vector<FlatGroup> found;
        for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
            const auto fullest = std::max_element(binArea_.begin(), binArea_.end());
            // The area of a plane is divided among at most eight bins.
            if (fullest == binArea_.end() || *fullest < leastArea_ / 8.0) break;
            const auto bin = static_cast<std::uint32_t>(fullest - binArea_.begin());
            const std::uint32_t seed = largestIn(bin);
            if (seed == kNone) {
                *fullest = 0.0;
                continue;
            }
            FlatGroup group = grownFrom(seed);
            const bool worth = group.area >= leastArea_ && !isLine(group) && !isFacet(group);
            retire(seed);
            for (const std::uint32_t t : group.triangles) {
                retire(t);
                taken_[t] = worth;
            }
            if (worth) found.push_back(std::move(group));
        }
        std::sort(found.begin(), found.end(), [](const FlatGroup& a, const FlatGroup& b) {
            return a.area != b.area ? a.area > b.area : a.triangles[0] < b.triangles[0];
        });
        if (found.size() > kMaxFlatParts) found.resize(kMaxFlatParts);
        for (FlatGroup& group : found) inMeshSpace(group);
        return found;
    }

private:
    struct Facet {
        glm::vec3 normal;   // unit
        float leastCosine;  // to the normal of its plane
        double area;
        std::uint32_t bin;  // kNone: too thin for a reliable normal
    };
    struct Box {
        glm::dvec3 min{1e9}, max{-1e9};
        void add(const glm::dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
        double diagonal() const { return glm::length(max - min); }
    };

    glm::dvec3 corner(std::uint32_t triangle, int i) const {
        const glm::dvec3 p(vertices_[triangles_[triangle][static_cast<std::size_t>(i)]].position);
        return (p - center_) * perUnit_;
    }

    void measure() {
        glm::dvec3 low(vertices_[triangles_[0][0]].position), high(low);
        for (const auto& t : triangles_) {
            for (const std::uint32_t v : t) {
                low = glm::min(low, glm::dvec3(vertices_[v].position));
                high = glm::max(high, glm::dvec3(vertices_[v].position));
            }
        }
        center_ = 0.5 * (low + high);
        // No triangle is degenerate, so the diagonal is positive. Scaling by a power of two is
        // exact.
        unit_ = std::exp2(std::floor(std::log2(glm::length(high - low))));
        perUnit_ = 1.0 / unit_;
        const glm::dvec3 extent = (high - low) * perUnit_;
        leastArea_ = kMinFlatShare *
                     std::max({extent.x * extent.y, extent.y * extent.z, extent.z * extent.x});
        // Half a unit in the last place of the largest coordinate, along each axis.
        const glm::dvec3 farthest = glm::max(glm::abs(low), glm::abs(high));
        noise_ = glm::length(farthest) * perUnit_ * std::exp2(-24.0);
    }

    void binTriangles() {
        facets_.resize(triangles_.size());
        taken_.assign(triangles_.size(), 0);
        retired_.assign(triangles_.size(), 0);
        // Open addressing from a bin's key to its index, in order of first use.
        const std::size_t mask = std::bit_ceil(2 * triangles_.size()) - 1;
        std::vector<std::uint32_t> table(mask + 1, kNone), keys;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            const glm::dvec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            const glm::dvec3 cross = glm::cross(b - a, c - a);
            const double length = glm::length(cross);
            const glm::dvec3 n = cross / length;
            const double longest = std::sqrt(
                std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)}));
            const double uncertainty = 4.0 * noise_ * longest / length;  // radians, by its height
            Facet& facet = facets_[t];
            facet.normal = glm::vec3(n);
            facet.area = 0.5 * length;
            facet.leastCosine = leastCosine(kSameDirection + uncertainty);
            facet.bin = kNone;
            if (!(uncertainty < 5.0 * kDegree)) continue;
            const std::uint32_t key = binOf(n, glm::dot(n, (a + b + c) / 3.0));
            std::size_t slot = (key * 0x9e3779b1u) & mask;
            while (table[slot] != kNone && keys[table[slot]] != key) slot = (slot + 1) & mask;
            if (table[slot] == kNone) {
                table[slot] = static_cast<std::uint32_t>(keys.size());
                keys.push_back(key);
                binArea_.push_back(0.0);
            }
            facet.bin = table[slot];
            binArea_[facet.bin] += facet.area;
        }
    }

    std::uint32_t largestIn(std::uint32_t bin) const {
        std::uint32_t largest = kNone;
        for (std::uint32_t t = 0; t < facets_.size(); ++t) {
            if (facets_[t].bin == bin && !retired_[t] &&
                (largest == kNone || facets_[t].area > facets_[largest].area)) {
                largest = t;
            }
        }
        return largest;
    }

    // Removes the triangle from its bin and from the seeds.
    void retire(std::uint32_t t) {
        if (retired_[t] || facets_[t].bin == kNone) return;
        retired_[t] = 1;
        binArea_[facets_[t].bin] -= facets_[t].area;
    }

    double farthestCorner(std::uint32_t t, const Plane& plane) const {
        return std::max({std::abs(plane.distance(corner(t, 0))),
                         std::abs(plane.distance(corner(t, 1))),
                         std::abs(plane.distance(corner(t, 2)))});
    }

    // Newell: the normal is the sum of the triangles' cross products; the plane contains their
    // centroid.
    Plane fitted(const std::vector<std::uint32_t>& triangles, double& area,
                 double& diagonal) const {
        glm::dvec3 normal(0.0), centroid(0.0);
        Box box;
        area = 0.0;
        for (const std::uint32_t t : triangles) {
            const glm::dvec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            const double size = facets_[t].area;
            normal += glm::cross(b - a, c - a);
            centroid += size * (a + b + c) / 3.0;
            area += size;
            box.add(a), box.add(b), box.add(c);
        }
        diagonal = box.diagonal();
        normal = glm::normalize(normal);  // all within 80 degrees of one direction: not zero
        return {normal, -glm::dot(normal, centroid / area)};
    }

    bool liesIn(std::uint32_t t, const Plane& plane, double tolerance) const {
        return glm::dot(facets_[t].normal, glm::vec3(plane.normal)) >= facets_[t].leastCosine &&
               farthestCorner(t, plane) <= tolerance;
    }

    FlatGroup grownFrom(std::uint32_t seed) const {
        FlatGroup group{.triangles = {seed}};
        double diagonal = 0.0;
        group.plane = fitted(group.triangles, group.area, diagonal);
        std::vector<std::uint32_t> candidates;
        const glm::vec3 direction(group.plane.normal);
        for (std::uint32_t t = 0; t < facets_.size(); ++t) {
            if (glm::dot(facets_[t].normal, direction) >= facets_[t].leastCosine - kCoarseCosine &&
                !taken_[t] && farthestCorner(t, group.plane) <= kCoarse) {
                candidates.push_back(t);
            }
        }
        for (int round = 0; round < kMaxRounds; ++round) {
            const double tolerance = std::max(kFlatness * diagonal, 2.0 * noise_);
            std::vector<std::uint32_t> next;
            for (const std::uint32_t t : candidates) {
                if (liesIn(t, group.plane, tolerance)) next.push_back(t);
            }
            if (next == group.triangles) return group;
            if (next.empty()) break;
            group.triangles = std::move(next);
            group.plane = fitted(group.triangles, group.area, diagonal);
        }
        // Not converged: the triangles may not fit the plane of the whole group.
        const double tolerance = std::max(kFlatness * diagonal, 2.0 * noise_);
        const bool flat =
            std::all_of(group.triangles.begin(), group.triangles.end(),
                        [&](std::uint32_t t) { return liesIn(t, group.plane, tolerance); });
        if (!flat) group.area = 0.0;
        return group;
    }

    // From the principal moments of the corners in the plane.
    bool isLine(const FlatGroup& group) const {
        const glm::dvec3& n = group.plane.normal;
        const glm::dvec3 axis = std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 u = glm::normalize(axis - glm::dot(axis, n) * n), v = glm::cross(n, u);
        const auto each = [&](auto&& visit) {
            for (const std::uint32_t t : group.triangles) {
                for (int i = 0; i < 3; ++i) {
                    const glm::dvec3 p = corner(t, i);
                    visit(glm::dvec2(glm::dot(p, u), glm::dot(p, v)));
                }
            }
        };
        glm::dvec2 mean(0.0);
        each([&](const glm::dvec2& p) { mean += p; });
        mean /= 3.0 * static_cast<double>(group.triangles.size());
        double xx = 0.0, xy = 0.0, yy = 0.0;
        each([&](const glm::dvec2& p) {
            const glm::dvec2 d = p - mean;
            xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
        });
        const double half = 0.5 * (xx + yy), root = std::hypot(0.5 * (xx - yy), xy);
        const double largest = half + root;
        // The smaller one from the determinant: half - root would cancel.
        const double smallest = (xx * yy - xy * xy) / largest;
        return !(smallest > kMinAspect * kMinAspect * largest);
    }

    // Whether most of the area has vertex normals that deviate as on a curved surface.
    bool isFacet(const FlatGroup& group) const {
        double leaning = 0.0;
        for (const std::uint32_t t : group.triangles) {
            for (const std::uint32_t v : triangles_[t]) {
                const double cosine = glm::dot(glm::dvec3(vertices_[v].normal), group.plane.normal);
                const double lean = std::acos(std::clamp(cosine, -1.0, 1.0));
                if (lean > kMinLean && lean < kMaxLean) leaning += facets_[t].area / 3.0;
            }
        }
        return leaning > 0.5 * group.area;
    }

    void inMeshSpace(FlatGroup& group) const {
        group.area *= unit_ * unit_;
        group.plane.offset = group.plane.offset * unit_ - glm::dot(group.plane.normal, center_);
    }

    std::span<const Vertex> vertices_;
    std::span<const std::array<std::uint32_t, 3>> triangles_;
    glm::dvec3 center_{0.0};
    double unit_ = 1.0, perUnit_ = 1.0, leastArea_ = 0.0, noise_ = 0.0;
    std::vector<Facet> facets_;
    std::vector<std::uint8_t> taken_, retired_;
    std::vector<double> binArea_;
};

}  // namespace

std::vector<FlatGroup> flatGroups(std::span<const Vertex> vertices,
                                  std::span<const std::array<std::uint32_t, 3>> triangles) {
    if (triangles.empty()) return {};
    return Finder(vertices, triangles).run();
}

}  // namespace clerestory
