// What a frame is planned from, apart from the request.
#pragma once

#include "scene/environment.h"
#include "scene/scene.h"

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>

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

}  // namespace clerestory
