// Everything except the request on which a plan depends.
#pragma once

#include "plan/graph/light_progress.h"
#include "plan/graph/target.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>

namespace clerestory {

// Where rays through the triangles of a scene are followed: nowhere, in the programs of the
// surfaces that they start from, or on the processor.
enum class Rays { none, shader, processor };

// Capabilities of the device on which plans are executed; see gl/context.h.
struct DeviceLimits {
    std::uint32_t maxAnisotropy = 16;
    bool software = true;
    Rays rays = Rays::shader;
    Storage display = Storage::driver;  // where tone mapping and the edge filter work
    bool fewPrograms = false;           // see RendererOptions::fewPrograms
    bool operator==(const DeviceLimits&) const = default;
};

// The maps that are resident on the GPU: their keys (TargetSpec::residentKey), and the key that the
// planner last derived from each set of inputs (TargetSpec::inputsHash).
struct ResidentMaps {
    std::set<std::uint64_t> keys;
    std::map<std::uint64_t, std::uint64_t> keyOfInputs = {};
};

// All loaded maps by name. Materials refer to them.
using EnvironmentMaps = std::map<std::string, std::shared_ptr<const EnvironmentMap>>;

// The members must outlive the context.
struct FrameContext {
    const Scene& scene;  // composed as the request says (scene/compose.h)
    const Pose& pose;    // at the time of the request
    const EnvironmentMap& environment;
    const EnvironmentMaps& maps;
    const ResidentMaps& resident;
    const DeviceLimits& limits;
    // Identifies the light at the vertices of `scene` (light/surface_light.h) in its present state;
    // 0: there is none, and nothing hides the environment.
    std::uint64_t surfaceLight = 0;
    LightProgress light = {};
    const Pose* flowPose = nullptr;  // at the time of output.flow; null without that channel
    bool needsRays = false;          // FramePlan::rays is wanted even if no draw traces rays
    bool convex = false;             // no surface of the scene sees another; see scene/convexity.h
};

}  // namespace clerestory
