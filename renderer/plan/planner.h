// The one place that decides: scene + request + maps already resident -> FramePlan. Pure.
#pragma once

#include "plan/graph/frame_plan.h"

#include <map>
#include <memory>
#include <set>

namespace clerestory {

// What the renderer at hand can do, found out once by gl/context.
struct DeviceLimits {
    std::uint32_t maxSamples = 4;
    std::uint32_t maxAnisotropy = 16;
    bool software = true;
    bool traces = true;  // rays through the mesh are offered
    bool operator==(const DeviceLimits&) const = default;
};

// The maps the GPU holds: their keys (TargetSpec::residentKey), and under which circumstances
// (TargetSpec::circumstances) each was last found to be the right one.
struct ResidentMaps {
    std::set<std::uint64_t> keys;
    std::map<std::uint64_t, std::uint64_t> keyUnder = {};
};

// What there is to say when a request names a clip that the scene does not have.
FieldError noSuchClip(const Scene& scene);

// Every map that is loaded, by name: materials may refer to one.
using EnvironmentMaps = std::map<std::string, std::shared_ptr<const EnvironmentMap>>;

// What a frame is planned in: everything that is not the request.
struct FrameContext {
    const Scene& scene;
    const Pose& pose;  // of the request's moment
    const EnvironmentMap& environment;
    const EnvironmentMaps& maps;
    const ResidentMaps& resident;
    const DeviceLimits& limits;
};

// Pure: equal arguments, equal plans.
//
//     FramePlan plan = planFrame({.scene = scene, .pose = pose, ...}, request);
//
// Throws InvalidRequest when the request names a camera that the scene does not have, or a view
// that cannot be drawn.
FramePlan planFrame(const FrameContext& context, const FrameRequest& request);

}  // namespace clerestory
