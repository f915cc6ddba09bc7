#include "plan/visibility/culling.h"

namespace clerestory {
namespace {
constexpr std::uint32_t kSmallDraw = 256;  // triangles
}  // namespace

Cluster Culling::joined(const Mesh& mesh, std::uint32_t& cluster, std::uint32_t end) const {
    const Scene& scene = stage_.scene;
    const auto box = [&] {
        return boundsOf(scene, stage_.pose, mesh, cluster - mesh.firstCluster);
    };
    Cluster sum = scene.clusters[cluster];
    sum.bounds = box();
    ++cluster;
    while (cluster < end && sum.indexCount + scene.clusters[cluster].indexCount <= 3 * kSmallDraw) {
        sum.indexCount += scene.clusters[cluster].indexCount;
        sum.bounds.add(box());
        ++cluster;
    }
    return sum;
}

}  // namespace clerestory
