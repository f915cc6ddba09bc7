// Passes that make cubes ready to be mirrored: blur, levels, a lobe for each roughness. See
// graph/pass.h for what every pass type says.
#pragma once

#include "plan/graph/target.h"
#include "scene/hash.h"
#include "scene/scene.h"

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

struct FramePlan;
struct Stage;

// A stored environment map into a resident cube.
struct PrefilterMap {
    std::string map;
    std::uint32_t samples = 64;  // directions for each texel

    std::string_view kind() const { return "environment"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const PrefilterMap&) const = default;
};

// A captured or blurred cube into a resident one.
struct PrefilterCube {
    TargetId source = kNoTarget;
    std::uint32_t samples = 32;  // directions for each texel

    std::string_view kind() const { return "prefilter"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const PrefilterCube&) const = default;
};

// One of the three turns of a Gaussian blur: about one axis of the cube.
struct BlurCube {
    TargetId source = kNoTarget;  // a cube; or, without one,
    std::string map;              // a stored map
    MapBlur blur;                 // of all three turns together
    std::uint32_t axis = 0;       // 0 to 2

    std::string_view kind() const { return "gaussian"; }
    std::vector<TargetId> reads() const;
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const BlurCube&) const = default;
};

// Averages the target into its smaller levels.
struct BuildLevels {
    std::string_view kind() const { return "levels"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const BuildLevels&) const = default;
};

}  // namespace clerestory
