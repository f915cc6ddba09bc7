#include "plan/effects/surroundings.h"

#include "plan/visibility/enclosure.h"

namespace clerestory {

double enclosureAt(ViewContext& context, const ViewTask& task, const Bounds& box) {
    if (task.generation > 0) return 0.0;
    const Stage& stage = context.stage;
    if (context.opaqueBoxes.empty()) {
        for (const Surface& surface : stage.surfaces) {
            if (surface.glass != Glass::none) continue;
            const Instance& instance = stage.scene.instances[surface.instance];
            const glm::dmat4 eyeFromMesh =
                eyeFromLocal(task.view, stage.pose.worldFromNode[instance.node]);
            const Mesh& mesh = stage.scene.meshes[instance.mesh];
            const std::uint32_t first = surface.firstCluster - mesh.firstCluster;
            for (std::uint32_t c = 0; c < surface.clusterCount; ++c) {
                const Bounds& cluster = boundsOf(stage.scene, stage.pose, mesh, first + c);
                context.opaqueBoxes.push_back(transformed(cluster, eyeFromMesh));
            }
        }
    }
    return enclosure(context.opaqueBoxes, glm::dvec3(box.center()));
}

}  // namespace clerestory
