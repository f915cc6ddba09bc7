// How much of the light between surfaces (Effects::indirectLight) a frame shows.
#pragma once

#include <cstdint>

namespace clerestory {

struct LightProgress {
    std::uint32_t revision = 0;  // completed rounds; 0: the frame shows the environment's light
    double share = 0.0;          // of the computation that is complete, 0..1
    bool failed = false;         // no more will be computed
    bool operator==(const LightProgress&) const = default;
};

}  // namespace clerestory
