#include "plan/visibility/enclosure.h"

#include "plan/visibility/visibility.h"

#include <algorithm>
#include <limits>

namespace clerestory {
namespace {

bool intersects(const Bounds& box, const glm::dvec3& from, const glm::dvec3& direction) {
    double near = 0.0, far = std::numeric_limits<double>::infinity();
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
        const double low = box.min[i] - from[i], high = box.max[i] - from[i];
        inside = inside && low <= 0.0 && high >= 0.0;
        if (direction[i] == 0.0) {
            if (low > 0.0 || high < 0.0) return false;
            continue;
        }
        near = std::max(near, std::min(low / direction[i], high / direction[i]));
        far = std::min(far, std::max(low / direction[i], high / direction[i]));
    }
    return !inside && near <= far;
}

}  // namespace

double enclosure(std::span<const Bounds> boxes, const glm::dvec3& position) {
    int blocked = 0, all = 0;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                const int along = x * x + y * y + z * z;
                if (along != 1 && along != 3) continue;
                ++all;
                const glm::dvec3 direction(x, y, z);
                blocked += std::any_of(boxes.begin(), boxes.end(), [&](const Bounds& box) {
                    return intersects(box, position, direction);
                });
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
