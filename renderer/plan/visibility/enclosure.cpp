#include "plan/visibility/enclosure.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

namespace clerestory {
namespace {

constexpr std::uint32_t kBoxesOfLeaf = 4;

struct Crossing {
    bool hits = false;      // the ray intersects the box
    bool contains = false;  // the box contains the origin of the ray
};

Crossing crossing(const Bounds& box, const glm::dvec3& origin, const glm::dvec3& direction) {
    double near = 0.0, far = std::numeric_limits<double>::infinity();
    bool contains = true;
    for (int i = 0; i < 3; ++i) {
        const double low = box.min[i] - origin[i], high = box.max[i] - origin[i];
        contains = contains && low <= 0.0 && high >= 0.0;
        if (direction[i] == 0.0) {
            if (low > 0.0 || high < 0.0) return {};
            continue;
        }
        near = std::max(near, std::min(low / direction[i], high / direction[i]));
        far = std::min(far, std::max(low / direction[i], high / direction[i]));
    }
    return {.hits = near <= far, .contains = contains};
}

// The axis on which the centres of the boxes differ most.
int longestAxis(std::span<const Bounds> boxes) {
    Bounds centers;
    for (const Bounds& box : boxes) centers.add(box.center());
    const glm::vec3 extent = centers.extent();
    const int wider = extent.y > extent.x ? 1 : 0;
    return extent.z > extent[wider] ? 2 : wider;
}

}  // namespace

BoxHierarchy::BoxHierarchy(std::vector<Bounds> boxes) : boxes_(std::move(boxes)) {
    std::erase_if(boxes_, [](const Bounds& box) { return box.empty(); });
    if (!boxes_.empty()) build(0, static_cast<std::uint32_t>(boxes_.size()));
}

void BoxHierarchy::build(std::uint32_t first, std::uint32_t end) {
    const std::size_t index = nodes_.size();
    const std::span<Bounds> boxes(boxes_.data() + first, end - first);
    Node node;
    for (const Bounds& box : boxes) node.bounds.add(box);
    const bool isLeaf = boxes.size() <= kBoxesOfLeaf;
    if (isLeaf) {
        node.first = first;
        node.end = end;
    }
    nodes_.push_back(node);
    if (!isLeaf) {
        const std::uint32_t middle = first + (end - first) / 2;
        std::nth_element(boxes.begin(), boxes.begin() + (middle - first), boxes.end(),
                         [axis = longestAxis(boxes)](const Bounds& a, const Bounds& b) {
                             return a.center()[axis] < b.center()[axis];
                         });
        build(first, middle);
        build(middle, end);
    }
    nodes_[index].skip = static_cast<std::uint32_t>(nodes_.size());
}

BoxHierarchy::Result BoxHierarchy::trace(const glm::dvec3& origin,
                                         const glm::dvec3& direction) const {
    Result result;
    for (std::uint32_t i = 0; i < nodes_.size();) {
        const Node& node = nodes_[i];
        result.visits += 1 + (node.end - node.first);
        if (result.visits > kMaxVisits) return {.blocked = true, .visits = kMaxVisits};
        if (!crossing(node.bounds, origin, direction).hits) {
            i = node.skip;
            continue;
        }
        for (std::uint32_t b = node.first; b < node.end; ++b) {
            const Crossing box = crossing(boxes_[b], origin, direction);
            if (box.hits && !box.contains) return {.blocked = true, .visits = result.visits};
        }
        ++i;
    }
    return result;
}

double enclosure(const BoxHierarchy& boxes, const glm::dvec3& position) {
    int blocked = 0, all = 0;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                const int along = x * x + y * y + z * z;
                if (along != 1 && along != 3) continue;
                ++all;
                blocked += boxes.trace(position, glm::dvec3(x, y, z)).blocked;
            }
        }
    }
    return double(blocked) / all;
}

std::vector<Bounds> opaqueBoxes(const Stage& stage, const View& view) {
    std::vector<Bounds> boxes;
    for (const Surface& surface : stage.surfaces) {
        if (surface.glass != Glass::none) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        const glm::dmat4 eyeFromMesh = eyeFromLocal(view, stage.pose.worldFromNode[instance.node]);
        const Mesh& mesh = stage.scene.meshes[instance.mesh];
        const std::uint32_t first = surface.firstCluster - mesh.firstCluster;
        for (std::uint32_t c = 0; c < surface.clusterCount; ++c) {
            const Bounds& cluster = boundsOf(stage.scene, stage.pose, mesh, first + c);
            boxes.push_back(transformed(cluster, eyeFromMesh));
        }
    }
    return boxes;
}

}  // namespace clerestory
