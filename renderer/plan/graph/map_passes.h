// Passes that prepare cubes for reflection: Gaussian blur, mip levels, prefiltering by roughness.
// graph/pass.h describes the members that every pass type has.
#pragma once

#include "plan/graph/sample_costs.h"
#include "plan/graph/target.h"
#include "scene/hash.h"
#include "scene/scene.h"

#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// Hashes every member.
void addBlur(PlanHash& hash, const MapBlur& blur);

// Prefilters a stored environment map into a resident cube.
struct PrefilterMap {
    std::string map;
    std::uint32_t samples = 64;  // directions per texel

    std::string_view kind() const { return "environment"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const PrefilterMap& work, const Stage& stage);
    bool operator==(const PrefilterMap&) const = default;
};

// Prefilters a captured or blurred cube into a resident one.
struct PrefilterCube {
    TargetId source = kNoTarget;
    std::uint32_t samples = 32;  // directions per texel

    std::string_view kind() const { return "prefilter"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const PrefilterCube& work, const Stage& stage);
    bool operator==(const PrefilterCube&) const = default;
};

// One of the three passes of a Gaussian blur: by rotations about one axis of the cube.
struct BlurCube {
    TargetId source = kNoTarget;  // a cube, or none: the stored map
    std::string map;
    MapBlur blur;            // of the three passes together
    std::uint32_t axis = 0;  // 0 to 2

    std::string_view kind() const { return "gaussian"; }
    std::vector<TargetId> reads() const;
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const BlurCube& work, const Stage& stage);
    bool operator==(const BlurCube&) const = default;
};

// Averages the first level of the target into its smaller levels.
struct BuildLevels {
    std::string_view kind() const { return "levels"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const BuildLevels& work, const Stage& stage);
    bool operator==(const BuildLevels&) const = default;
};

}  // namespace clerestory
