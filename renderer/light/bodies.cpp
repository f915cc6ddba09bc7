#include "light/bodies.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <tuple>

namespace clerestory::light {
namespace {

// Larger meshes are not examined; it would take longer than a tenth of a second.
constexpr std::size_t kMaxTriangles = 100'000;

using Corners = std::array<glm::vec3, 3>;

bool before(const glm::vec3& a, const glm::vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

// Whether each edge belongs to two triangles that pass it in opposite directions. Corners are the
// same if their positions are.
bool closed(std::span<const Corners> triangles) {
    std::vector<glm::vec3> positions;
    for (const Corners& corners : triangles) {
        positions.insert(positions.end(), corners.begin(), corners.end());
    }
    std::sort(positions.begin(), positions.end(), before);
    positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
    std::vector<std::uint64_t> edges;
    const auto indexOf = [&](const glm::vec3& p) {
        return static_cast<std::uint64_t>(
            std::lower_bound(positions.begin(), positions.end(), p, before) - positions.begin());
    };
    for (const Corners& corners : triangles) {
        const std::uint64_t index[3] = {indexOf(corners[0]), indexOf(corners[1]),
                                        indexOf(corners[2])};
        if (index[0] == index[1] || index[1] == index[2] || index[2] == index[0]) continue;
        for (int k = 0; k < 3; ++k) edges.push_back(index[k] << 32 | index[(k + 1) % 3]);
    }
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
    return !edges.empty() && std::all_of(edges.begin(), edges.end(), [&](std::uint64_t edge) {
        return std::binary_search(edges.begin(), edges.end(), edge << 32 | edge >> 32);
    });
}

// Six times the volume, if the triangles are closed; positive if they face outwards.
double volumeOf(std::span<const Corners> triangles) {
    double sum = 0.0;
    for (const auto& [a, b, c] : triangles) {
        const glm::dvec3 origin(triangles.front()[0]);
        sum += glm::dot(glm::dvec3(a) - origin,
                        glm::cross(glm::dvec3(b) - origin, glm::dvec3(c) - origin));
    }
    return sum;
}

bool contains(const Bounds& box, const glm::vec3& point) {
    return glm::all(glm::lessThanEqual(box.min, point)) &&
           glm::all(glm::lessThanEqual(point, box.max));
}

// Boxes of all instances, world axes from the origin.
class Boxes {
public:
    Boxes(const Scene& scene, const Pose& pose, const glm::dvec3& origin) {
        for (const Instance& instance : scene.instances) {
            const glm::dmat4 fromNode =
                glm::translate(glm::dmat4(1.0), -origin) * pose.worldFromNode[instance.node];
            boxes_.push_back(transformed(scene.meshes[instance.mesh].bounds, fromNode));
            if (finite(boxes_.back())) byCenter_.push_back(boxes_.size() - 1);
        }
        std::sort(byCenter_.begin(), byCenter_.end(), [&](std::size_t a, std::size_t b) {
            return boxes_[a].center().x < boxes_[b].center().x;
        });
    }
    const Bounds& operator[](std::size_t instance) const { return boxes_[instance]; }

    // Whether the box of another instance is smaller and has its centre in that of this one. It may
    // reach out of it: a chair's feet through the floor of a room.
    bool holdsAnother(std::size_t instance) const {
        const Bounds& box = boxes_[instance];
        auto next = std::lower_bound(
            byCenter_.begin(), byCenter_.end(), box.min.x,
            [&](std::size_t other, float x) { return boxes_[other].center().x < x; });
        for (; next != byCenter_.end() && boxes_[*next].center().x <= box.max.x; ++next) {
            if (*next != instance && contains(box, boxes_[*next].center()) &&
                boxes_[*next].diagonal() <= box.diagonal()) {
                return true;
            }
        }
        return false;
    }

private:
    std::vector<Bounds> boxes_;
    std::vector<std::size_t> byCenter_;
};

}  // namespace

std::vector<bool> closedBodies(const BakeInput& input, const rays::TriangleTree& tree,
                               const std::vector<Face>& faces, const glm::dvec3& origin) {
    const std::size_t count = input.scene->instances.size();
    std::vector<std::vector<std::uint32_t>> triangles(count);
    std::vector<bool> candidate(count, true), bodies(count, false);
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const auto instance = static_cast<std::size_t>(tree.triangle(i).instance);
        candidate[instance] = candidate[instance] && faces[i].plain && faces[i].twoSided &&
                              faces[i].emitted == glm::vec3(0.0f) &&
                              triangles[instance].size() < kMaxTriangles;
        if (candidate[instance]) triangles[instance].push_back(i);
    }
    const Boxes boxes(*input.scene, *input.pose, origin);
    std::vector<Corners> corners;
    for (std::size_t instance = 0; instance < count; ++instance) {
        if (!candidate[instance] || triangles[instance].empty()) continue;
        corners.clear();
        for (const std::uint32_t i : triangles[instance]) {
            const BvhTriangle& t = tree.triangle(i);
            const bool turned = glm::dot(glm::cross(t.b - t.a, t.c - t.a), faces[i].normal) < 0.0f;
            corners.push_back(turned ? Corners{t.a, t.c, t.b} : Corners{t.a, t.b, t.c});
        }
        const auto within = [&](const PlacedLight& light) {
            return light.kind != LightKind::directional &&
                   contains(boxes[instance], glm::vec3(light.position - origin));
        };
        bodies[instance] = closed(corners) && volumeOf(corners) > 0.0 &&
                           std::none_of(input.lights.begin(), input.lights.end(), within) &&
                           !boxes.holdsAnother(instance);
    }
    return bodies;
}

}  // namespace clerestory::light
