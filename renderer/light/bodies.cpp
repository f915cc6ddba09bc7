#include "light/bodies.h"

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

bool within(const Bounds& box, const Bounds& outer) {
    return !box.empty() && glm::all(glm::greaterThanEqual(box.min, outer.min)) &&
           glm::all(glm::lessThanEqual(box.max, outer.max));
}

// World axes, relative to the origin.
Bounds movedBounds(const Bounds& box, const glm::dmat4& worldFromNode, const glm::dvec3& origin) {
    Bounds moved;
    if (box.empty()) return moved;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                           corner & 4 ? box.max.z : box.min.z);
        moved.add(glm::vec3(glm::dvec3(worldFromNode * glm::dvec4(p, 1.0)) - origin));
    }
    return moved;
}

}  // namespace

std::vector<bool> closedBodies(const BakeInput& input, const rays::TriangleTree& tree,
                               const std::vector<Face>& faces, const glm::dvec3& origin) {
    const Scene& scene = *input.scene;
    const std::size_t count = scene.instances.size();
    std::vector<std::vector<Corners>> triangles(count);
    std::vector<bool> candidate(count, true), bodies(count, false);
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        const auto instance = static_cast<std::size_t>(t.instance);
        candidate[instance] = candidate[instance] && faces[i].plain && faces[i].twoSided &&
                              triangles[instance].size() < kMaxTriangles;
        if (!candidate[instance]) continue;
        const bool turned = glm::dot(glm::cross(t.b - t.a, t.c - t.a), faces[i].normal) < 0.0f;
        triangles[instance].push_back(turned ? Corners{t.a, t.c, t.b} : Corners{t.a, t.b, t.c});
    }
    std::vector<Bounds> boxes;
    for (const Instance& instance : scene.instances) {
        boxes.push_back(movedBounds(scene.meshes[instance.mesh].bounds,
                                    input.pose->worldFromNode[instance.node], origin));
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (!candidate[i] || triangles[i].empty() || !closed(triangles[i]) ||
            !(volumeOf(triangles[i]) > 0.0)) {
            continue;
        }
        const auto holds = [&](std::size_t other) {
            return other != i && within(boxes[other], boxes[i]);
        };
        bool empty = std::none_of(input.lights.begin(), input.lights.end(), [&](const auto& lamp) {
            const glm::vec3 at(lamp.position - origin);
            return lamp.kind != LightKind::directional && within({at, at}, boxes[i]);
        });
        for (std::size_t k = 0; empty && k < count; ++k) empty = !holds(k);
        bodies[i] = empty;
    }
    return bodies;
}

}  // namespace clerestory::light
