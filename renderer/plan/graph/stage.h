// The scene of a frame with its pose, settings and materials resolved; shared by all views. The
// members must outlive it.
#pragma once

#include "plan/graph/draw.h"
#include "plan/request/view_settings.h"
#include "scene/classification.h"
#include "scene/environment.h"
#include "scene/hash.h"

#include <span>
#include <vector>

namespace clerestory {

struct Stage {
    const Scene& scene;
    const Pose& pose;
    const ViewSettings& settings;
    const MaterialBindings& materials;
    std::uint64_t materialsHash = 0;       // of all `materials`; 0 if the frame has none
    std::vector<std::uint64_t> ownHashes;  // of each of materials.own
    std::uint64_t surfaceLight = 0;        // as FrameContext::surfaceLight
    std::span<const Surface> surfaces;
    std::vector<PlacedLight> lights;
    const EnvironmentMap& environment;
    bool fewPrograms = false;  // DeviceLimits::fewPrograms

    const Material& material(const Surface& s) const {
        return materials.material(scene, s.material);
    }
    // The frame's own materials by content: their indices depend on other changes of the frame.
    void addMaterial(PlanHash& hash, Index index) const;
};

}  // namespace clerestory
