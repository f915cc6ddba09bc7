// Construction with the binned surface area heuristic (Wald 2007), and traversal.
#include "scene/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

constexpr int kBins = 16;
constexpr std::uint32_t kMaxInLeaf = 4;
// Cost of visiting a node, in triangle tests (both fetch a similar number of bytes).
constexpr float kNodeCost = 1.0f;
// Below this depth nodes are split into equal halves, so recursion is bounded.
constexpr int kMaxSearchDepth = 40;
// Largest coordinate, metres from the centre: areas times counts stay finite in float.
constexpr float kFarthest = 1e15f;
constexpr std::uint32_t kExactWholeNumbers = 1u << 24;

struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};

    void add(const glm::vec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    void add(const Box& b) {
        low = glm::min(low, b.low);
        high = glm::max(high, b.high);
    }
    // Half the surface area.
    float area() const {
        const glm::vec3 d = high - low;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

struct Item {
    Box box;
    std::uint32_t triangle = 0;                                     // in the list of all triangles
    glm::vec3 doubledCenter() const { return box.low + box.high; }  // 2 * centre
};

bool finitePoint(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool pointInReach(const glm::vec3& v) {
    return glm::all(glm::lessThanEqual(glm::abs(v), glm::vec3(kFarthest)));
}

// In double, so that triangles whose area underflows in float are not dropped.
bool hasArea(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::dvec3 n = glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
    return glm::dot(n, n) > 0.0;
}

float sideOf(const Material& material, const glm::dmat4& worldFromModel) {
    if (material.doubleSided || material.transmission > 0.0f) return 0.0f;
    return glm::determinant(glm::dmat3(worldFromModel)) < 0.0 ? -1.0f : 1.0f;
}

// Of the chosen instances; an upper bound of what gathered() returns.
std::uint64_t countTriangles(const Scene& scene, const std::vector<bool>& chosen) {
    std::uint64_t count = 0;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (std::uint32_t k = 0; chosen[i] && k < mesh.clusterCount; ++k) {
            count += scene.clusters[mesh.firstCluster + k].indexCount / 3;
        }
    }
    return count;
}

// The triangles of the chosen instances; at most `most`.
std::vector<BvhTriangle> gathered(const Scene& scene, const Pose& pose,
                                  const MaterialBindings& materials, const glm::dvec3& origin,
                                  const std::vector<bool>& chosen, std::uint64_t most,
                                  std::uint64_t& dropped) {
    std::vector<BvhTriangle> triangles;
    triangles.reserve(std::min(most, countTriangles(scene, chosen)));
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (!chosen[i] || isShadowCatcher(scene, i) || !materials.draws(i) ||
            mesh.primitive != Primitive::triangles)
            continue;
        const glm::dmat4& worldFromModel = pose.worldFromNode[instance.node];
        const float side =
            sideOf(materials.material(scene, materials.materialOf(scene, i)), worldFromModel);
        const MeshVertices vertices = verticesOf(scene, pose, mesh);
        for (std::uint32_t k = 0; k < mesh.clusterCount; ++k) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + k];
            for (std::uint32_t j = 0; j < cluster.indexCount; j += 3) {
                const std::uint32_t first = cluster.firstIndex + j;
                glm::vec3 corners[3];
                for (int corner = 0; corner < 3; ++corner) {
                    const glm::vec3& p = vertices[scene.indices[first + corner]].position;
                    corners[corner] =
                        glm::vec3(glm::dvec3(worldFromModel * glm::dvec4(p, 1.0)) - origin);
                }
                const auto& [a, b, c] = corners;
                if (triangles.size() == most || first / 3 >= kExactWholeNumbers ||
                    i >= kExactWholeNumbers || !pointInReach(a) || !pointInReach(b) ||
                    !pointInReach(c) || !hasArea(a, b, c)) {
                    ++dropped;
                    continue;
                }
                triangles.push_back(
                    {a, static_cast<float>(first / 3), b, static_cast<float>(i), c, side});
            }
        }
    }
    return triangles;
}

struct Split {
    int axis = -1;
    int bin = 0;  // the last one of the left child
    float cost = std::numeric_limits<float>::infinity();
};

class Builder {
public:
    // farthest: the largest coordinate that rays reach, if larger than those of the triangles.
    Builder(const std::vector<BvhTriangle>& triangles, float farthest, Bvh& bvh)
        : triangles_(triangles), bvh_(bvh) {
        Box all;
        items_.reserve(triangles.size());
        for (const BvhTriangle& t : triangles) {
            Item item;
            for (const glm::vec3& p : {t.a, t.b, t.c}) item.box.add(p);
            item.triangle = static_cast<std::uint32_t>(items_.size());
            all.add(item.box);
            items_.push_back(item);
        }
        const glm::vec3 greatest = glm::max(glm::abs(all.low), glm::abs(all.high));
        // The rounding error of a ray at the largest coordinate: box tests and triangle tests round
        // differently.
        slack_ = 4e-7f * std::max({greatest.x, greatest.y, greatest.z, farthest});
        bvh.nodes.reserve(triangles.size());
        bvh.triangles.reserve(triangles.size());
        build(0, static_cast<std::uint32_t>(items_.size()), 0);
    }

private:
    void build(std::uint32_t begin, std::uint32_t end, int depth) {
        const std::size_t node = bvh_.nodes.size();
        bvh_.nodes.emplace_back();
        Box box, middles;
        for (std::uint32_t i = begin; i < end; ++i) {
            box.add(items_[i].box);
            middles.add(items_[i].doubledCenter());
        }
        bvh_.nodes[node].low = box.low - slack_;
        bvh_.nodes[node].high = box.high + slack_;
        const std::uint32_t count = end - begin;
        const Split split =
            depth < kMaxSearchDepth && count > 1 ? bestSplit(begin, end, middles) : Split{};
        const float area = box.area();
        const bool pays =
            split.axis >= 0 && kNodeCost * area + split.cost < static_cast<float>(count) * area;
        if (count == 1 || (count <= kMaxInLeaf && !pays)) {
            bvh_.nodes[node].leaf =
                static_cast<float>(kBvhLeafCount * bvh_.triangles.size() + count);
            for (std::uint32_t i = begin; i < end; ++i) {
                bvh_.triangles.push_back(triangles_[items_[i].triangle]);
            }
        } else {
            const std::uint32_t middle = partition(begin, end, split, middles);
            build(begin, middle, depth + 1);
            build(middle, end, depth + 1);
        }
        bvh_.nodes[node].skip = static_cast<float>(bvh_.nodes.size());
    }

    static int binOf(float middle, float low, float perUnit) {
        return std::min(kBins - 1, static_cast<int>((middle - low) * perUnit));
    }
    static glm::vec3 binsPerUnit(const Box& middles) {
        const glm::vec3 extent = middles.high - middles.low;
        glm::vec3 perUnit(0.0f);
        for (int axis = 0; axis < 3; ++axis) {
            const float k = kBins * (1.0f - 1e-6f) / extent[axis];
            if (extent[axis] > 0.0f && std::isfinite(k)) perUnit[axis] = k;
        }
        return perUnit;
    }

    Split bestSplit(std::uint32_t begin, std::uint32_t end, const Box& middles) const {
        struct Bin {
            Box box;
            std::uint32_t count = 0;
        };
        std::array<std::array<Bin, kBins>, 3> bins;
        const glm::vec3 perUnit = binsPerUnit(middles);
        for (std::uint32_t i = begin; i < end; ++i) {
            const glm::vec3 middle = items_[i].doubledCenter();
            for (int axis = 0; axis < 3; ++axis) {
                Bin& bin = bins[axis][binOf(middle[axis], middles.low[axis], perUnit[axis])];
                bin.box.add(items_[i].box);
                ++bin.count;
            }
        }
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(perUnit[axis] > 0.0f)) continue;
            std::array<float, kBins> right;  // of all bins above k
            Box box;
            std::uint32_t count = 0;
            for (int k = kBins - 1; k > 0; --k) {
                box.add(bins[axis][k].box);
                count += bins[axis][k].count;
                right[k - 1] = count > 0 ? box.area() * static_cast<float>(count) : -1.0f;
            }
            box = {};
            count = 0;
            for (int k = 0; k + 1 < kBins; ++k) {
                box.add(bins[axis][k].box);
                count += bins[axis][k].count;
                if (count == 0 || right[k] < 0.0f) continue;
                const float cost = box.area() * static_cast<float>(count) + right[k];
                if (cost < best.cost) best = {axis, k, cost};
            }
        }
        return best;
    }

    // Without a split: equal halves.
    std::uint32_t partition(std::uint32_t begin, std::uint32_t end, const Split& split,
                            const Box& middles) {
        const std::uint32_t half = begin + (end - begin) / 2;
        if (split.axis < 0) return half;
        const float low = middles.low[split.axis], perUnit = binsPerUnit(middles)[split.axis];
        const auto at =
            std::partition(items_.begin() + begin, items_.begin() + end, [&](const Item& item) {
                return binOf(item.doubledCenter()[split.axis], low, perUnit) <= split.bin;
            });
        return static_cast<std::uint32_t>(at - items_.begin());
    }

    const std::vector<BvhTriangle>& triangles_;
    Bvh& bvh_;
    std::vector<Item> items_;
    float slack_ = 0.0f;
};

// Of the bounds of all instances that are in range.
glm::dvec3 centerOf(const Scene& scene, const Pose& pose) {
    Bounds bounds;
    for (const Instance& instance : scene.instances) {
        const Bounds box = transformed(boundsOf(pose, scene.meshes[instance.mesh]),
                                       pose.worldFromNode[instance.node]);
        if (pointInReach(box.min) && pointInReach(box.max)) bounds.add(box);
    }
    if (bounds.empty()) return glm::dvec3(0.0);
    return 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
}

}  // namespace

namespace {

// Common to both parts of a tree, and independent of time.
struct Frame {
    glm::dvec3 origin{0.0};
    float farthest = 0.0f;  // the largest coordinate of both parts
};

Frame frameOf(const Scene& scene, const Pose& pose) {
    const Bounds& reach = scene.reach;
    if (reach.empty() || !pointInReach(reach.min) || !pointInReach(reach.max)) {
        return {centerOf(scene, pose), 0.0f};
    }
    const glm::vec3 half = 0.5f * reach.extent();
    return {0.5 * (glm::dvec3(reach.min) + glm::dvec3(reach.max)),
            std::max({half.x, half.y, half.z})};
}

Bvh built(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
          const Frame& frame, const std::vector<bool>& chosen, std::uint64_t most) {
    Bvh bvh;
    bvh.origin = frame.origin;
    const std::vector<BvhTriangle> triangles =
        gathered(scene, pose, materials, bvh.origin, chosen, most, bvh.dropped);
    if (!triangles.empty()) Builder(triangles, frame.farthest, bvh);
    return bvh;
}

void append(Bvh& to, const Bvh& part) {
    const auto nodes = static_cast<float>(to.nodes.size());
    const auto triangles = static_cast<float>(kBvhLeafCount * to.triangles.size());
    for (BvhNode node : part.nodes) {
        node.skip += nodes;
        if (node.leaf >= 0.0f) node.leaf += triangles;
        to.nodes.push_back(node);
    }
    to.triangles.insert(to.triangles.end(), part.triangles.begin(), part.triangles.end());
    to.dropped += part.dropped;
}

}  // namespace

Bvh buildStill(const Scene& scene, const Pose& pose, const MaterialBindings& materials) {
    std::vector<bool> chosen = instancesThatMove(scene);
    chosen.flip();
    return built(scene, pose, materials, frameOf(scene, pose), chosen, kMaxBvhTriangles);
}

Bvh buildMoving(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
                const Bvh& still) {
    Frame frame = frameOf(scene, pose);
    frame.origin = still.origin;
    return built(scene, pose, materials, frame, instancesThatMove(scene),
                 kMaxBvhTriangles - still.triangles.size());
}

std::vector<float> sidesOf(const Scene& scene, const MaterialBindings& materials) {
    std::vector<float> sides;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        constexpr float kHidden = 2.0f;
        const Material& material = materials.material(scene, materials.materialOf(scene, i));
        sides.push_back(materials.draws(i) ? sideOf(material, glm::dmat4(1.0)) : kHidden);
    }
    return sides;
}

BvhTriangles stillTriangles(const Scene& scene, const Pose& pose,
                            const MaterialBindings& materials) {
    std::vector<bool> chosen = instancesThatMove(scene);
    chosen.flip();
    const glm::dvec3 origin = frameOf(scene, pose).origin;
    std::uint64_t dropped = 0;
    return {origin, gathered(scene, pose, materials, origin, chosen, kMaxBvhTriangles, dropped)};
}

BvhTriangles movingTriangles(const Scene& scene, const Pose& pose,
                             const MaterialBindings& materials, std::size_t stillCount) {
    const glm::dvec3 origin = frameOf(scene, pose).origin;
    std::uint64_t dropped = 0;
    return {origin, gathered(scene, pose, materials, origin, instancesThatMove(scene),
                             kMaxBvhTriangles - stillCount, dropped)};
}

Bvh joined(const Bvh& still, const Bvh& moving) {
    if (moving.nodes.empty()) return still;
    if (still.nodes.empty()) return moving;
    Bvh both;
    both.origin = still.origin;
    const BvhNode &a = still.nodes.front(), &b = moving.nodes.front();
    both.nodes.push_back({glm::min(a.low, b.low), 0.0f, glm::max(a.high, b.high), -1.0f});
    append(both, still);
    append(both, moving);
    both.nodes.front().skip = static_cast<float>(both.nodes.size());
    return both;
}

Bvh buildBvh(const Scene& scene, const Pose& pose, const MaterialBindings& materials) {
    const Bvh still = buildStill(scene, pose, materials);
    return joined(still, buildMoving(scene, pose, materials, still));
}

namespace {

// Two axes perpendicular to a ray. In their plane the ray is the origin.
struct RayFrame {
    glm::vec3 along, s, t;
    explicit RayFrame(const glm::vec3& d) : along(d) {
        const float sign = d.z >= 0.0f ? 1.0f : -1.0f;  // Duff et al. 2017, as in sampling.glsl
        const float a = -1.0f / (sign + d.z), b = d.x * d.y * a;
        s = {1.0f + sign * d.x * d.x * a, sign * b, -sign * d.x};
        t = {b, sign + d.y * d.y * a, -d.y};
    }
    glm::vec3 operator()(const glm::vec3& p) const {
        return {glm::dot(p, s), glm::dot(p, t), glm::dot(p, along)};
    }
};

float reciprocal(float x) {
    return 1.0f / (std::abs(x) > 1e-18f ? x : std::copysign(1e-18f, x));
}

}  // namespace

std::optional<BvhHit> nearestHit(const Bvh& bvh, const glm::vec3& origin,
                                 const glm::vec3& direction, float tMin, float tMax) {
    const float length = glm::length(direction);
    if (!(length > 0.0f && length < 1e18f) || !finitePoint(origin)) return std::nullopt;
    const RayFrame frame(direction / length);
    const glm::vec3 d = frame.along;
    const glm::vec3 perUnit(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z));
    const float from = tMin * length;
    float nearest = tMax * length;
    std::optional<BvhHit> hit;

    std::size_t at = 0;
    while (at < bvh.nodes.size()) {
        const BvhNode& node = bvh.nodes[at];
        const glm::vec3 t0 = (node.low - origin) * perUnit, t1 = (node.high - origin) * perUnit;
        const glm::vec3 low = glm::min(t0, t1), high = glm::max(t0, t1);
        const float entry = std::max({low.x, low.y, low.z, from});
        const float exit = std::min({high.x, high.y, high.z, nearest});
        const bool met = entry <= exit;
        at = met && node.leaf < 0.0f ? at + 1 : static_cast<std::size_t>(node.skip);
        if (!met || node.leaf < 0.0f) continue;

        const auto leaf = static_cast<std::uint32_t>(node.leaf);
        for (std::uint32_t k = 0; k < leaf % kBvhLeafCount; ++k) {
            const BvhTriangle& triangle = bvh.triangles[leaf / kBvhLeafCount + k];
            const glm::vec3 a = frame(triangle.a - origin), b = frame(triangle.b - origin),
                            c = frame(triangle.c - origin);
            // Twice the areas of the sub-triangles (Woop et al. 2013); all of one sign inside.
            const float u = c.x * b.y - c.y * b.x, v = a.x * c.y - a.y * c.x,
                        w = b.x * a.y - b.y * a.x;
            const float sum = u + v + w;
            const float least = std::min({u, v, w}), most = std::max({u, v, w});
            // Positive if a, b, c are counter-clockwise along the ray.
            if (!((least >= 0.0f || most <= 0.0f) && sum != 0.0f && sum * triangle.side >= 0.0f)) {
                continue;
            }
            const float t = (u * a.z + v * b.z + w * c.z) / sum;
            if (!(t > from && t < nearest)) continue;
            nearest = t;
            hit =
                BvhHit{t / length, v / sum, w / sum, static_cast<std::uint32_t>(triangle.triangle),
                       static_cast<std::uint32_t>(triangle.instance)};
        }
    }
    return hit;
}

}  // namespace clerestory
