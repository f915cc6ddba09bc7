// Properties of instances and materials that ray tracing needs in a frame, in addition to meshes
// and materials. The planner determines them; every tracer reads them.
#pragma once

#include "plan/graph/draw.h"
#include "scene/classification.h"

#include <vector>

namespace clerestory {

struct RayScene {
    // One for each instance of the scene.
    struct InstanceProperties {
        Glass glass = Glass::none;
        std::vector<std::uint8_t> lights;  // lights that reach it; indices of FramePlan::lights
        bool operator==(const InstanceProperties&) const = default;
    };
    // One for each of Scene::materials, then for each of FramePlan::materials.
    struct MaterialProperties {
        bool mirrorsWhereFlat = false, mirrorsWhereCurved = false;
        bool operator==(const MaterialProperties&) const = default;
    };
    std::vector<InstanceProperties> instances;
    std::vector<MaterialProperties> materials;
    std::vector<Index> materialOfInstance;  // as in MaterialBindings
    std::vector<bool> hidden;               // likewise
    Features hitFeatures = 0;               // union of the features of all surfaces
    std::uint32_t bounces = 0;              // as Accuracy::bounces
    float leastShare = 0.0f;  // of a ray in its pixel, 0..1; rays with less are not followed
    // One pixel in stride x stride follows a ray of its own; see rays::Density. Processor only.
    std::uint32_t stride = 1;
    std::uint32_t finest = 1;
    float contrast = 0.0f, contrastNextTo = 0.0f, contrastBetween = 0.0f;
    // Of a rough lobe, mirrored and through glass; see rays::Density. Processor only.
    std::uint32_t lobePaths = 1, glassLobePaths = 1;
    // What hides lights from what a ray meets is found by rays, not in the shadow map. Processor
    // only.
    bool shadowRays = false;
    bool operator==(const RayScene&) const = default;
};

}  // namespace clerestory
