// Which clusters of surfaces are in a view.
//
//     Culling culling(stage, view);
//     for (const Surface& surface : stage.surfaces)
//         culling.eachInView(surface, [&](const Cluster& cluster, const Bounds& box) { ... });
#pragma once

#include "plan/graph/stage.h"
#include "plan/visibility/visibility.h"

#include <cstdint>

namespace clerestory {

class Culling {
public:
    // The arguments must outlive this.
    Culling(const Stage& stage, const View& view)
        : stage_(stage), view_(view), frustum_(frustumOf(view)) {}

    // use(cluster, box relative to the eye): of each one in view; small ones are joined. Returns
    // the number of the others.
    template <class Use>
    std::uint64_t eachInView(const Surface& surface, const Use& use) {
        const Instance& instance = stage_.scene.instances[surface.instance];
        const Mesh& mesh = stage_.scene.meshes[instance.mesh];
        if (testedInstance_ != surface.instance) {
            testedInstance_ = surface.instance;
            toEye_ = eyeFromLocal(view_, stage_.pose.worldFromNode[instance.node]);
            instanceOutside_ = outside(frustum_, transformed(boundsOf(stage_.pose, mesh), toEye_));
        }
        if (instanceOutside_) return surface.clusterCount;
        std::uint64_t culled = 0;
        const std::uint32_t end = surface.firstCluster + surface.clusterCount;
        for (std::uint32_t c = surface.firstCluster; c < end;) {
            const std::uint32_t first = c;
            const Cluster cluster = joined(mesh, c, end);
            const Bounds box = transformed(cluster.bounds, toEye_);
            if (outside(frustum_, box) || clippedAway(view_, box)) {
                culled += c - first;
            } else {
                use(cluster, box);
            }
        }
        return culled;
    }
    // Of the last surface.
    const glm::dmat4& toEye() const { return toEye_; }

private:
    // Joins consecutive small clusters (the sides of a box), which are culled and drawn together.
    // Advances `cluster` past the last of them.
    Cluster joined(const Mesh& mesh, std::uint32_t& cluster, std::uint32_t end) const;

    const Stage& stage_;
    const View& view_;
    const Frustum frustum_;
    Index testedInstance_ = kNone;
    bool instanceOutside_ = false;
    glm::dmat4 toEye_{1.0};
};

}  // namespace clerestory
