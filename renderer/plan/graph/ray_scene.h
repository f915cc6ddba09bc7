// What rays meet in one frame, beyond meshes and materials themselves: decided once by the planner,
// read by whatever traces.
#pragma once

#include "plan/graph/draw.h"
#include "scene/classification.h"

#include <vector>

namespace clerestory {

struct RayScene {
    // Of each instance of the scene.
    struct InstanceProperties {
        Glass glass = Glass::none;         // a thin sheet is a pane, whatever its material says
        std::vector<std::uint8_t> lights;  // that can reach it, into FramePlan::lights
        bool operator==(const InstanceProperties&) const = default;
    };
    // Of each material: the scene's, then FramePlan::materials.
    struct MaterialProperties {
        bool mirrorsWhereFlat = false, mirrorsWhereCurved = false;
        bool operator==(const MaterialProperties&) const = default;
    };
    std::vector<InstanceProperties> instances;
    std::vector<MaterialProperties> materials;
    std::vector<Index> materialOfInstance;  // as in MaterialBindings
    Features hitFeatures = 0;               // all that shading any hit may need
    std::uint32_t bounces = 0;              // turns of a ray
    bool operator==(const RayScene&) const = default;
};

}  // namespace clerestory
