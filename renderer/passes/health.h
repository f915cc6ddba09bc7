// Counts what must not be in a picture: texels that are NaN, infinite or negative light.
#pragma once

#include "passes/targets.h"
#include "plan/graph/frame_plan.h"

#include <cstdint>
#include <vector>

namespace clerestory {

struct TexelCounts {
    std::uint64_t texels = 0;     // of all levels and faces
    std::uint64_t nonFinite = 0;  // with a NaN or an infinity in any channel
    std::uint64_t negative = 0;   // of the others: with a negative channel, where light is held
};

// One for each of plan.targets, by reading all of it back: a check, not for every frame. All 0 for
// targets that are not float. Directions may be negative: of those nothing is counted as such.
std::vector<TexelCounts> examined(const FramePlan& plan, const std::vector<Target*>& targets);

}  // namespace clerestory
