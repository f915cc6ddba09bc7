// The one place that decides: scene + request + maps already resident -> FramePlan. Pure.
#pragma once

#include "plan/frame_plan.h"

#include <set>

namespace clerestory {

// What the renderer at hand can do, found out once by gl/context.
struct DeviceLimits {
    std::uint32_t maxSamples = 4;
    std::uint32_t maxAnisotropy = 16;
    bool software = true;
    bool traces = false;  // rays through the mesh are offered
    bool operator==(const DeviceLimits&) const = default;
};

// Keys (TargetSpec::residentKey) of the maps the GPU holds.
struct ResidentMaps {
    std::set<std::uint64_t> keys;
};

// Throws InvalidRequest when the request names a camera that the scene does not have, or a view
// that cannot be drawn.
FramePlan planFrame(const Scene& scene, const Pose& pose, const FrameRequest& request,
                    const EnvironmentMap& environment, const ResidentMaps& resident,
                    const DeviceLimits& limits);

}  // namespace clerestory
