// What a pass type needs to know of its frame to state its cost in samples; see graph/work.h.
#pragma once

#include <cstdint>
#include <string_view>

namespace clerestory {

// Settings of a frame that multiply the samples of its passes.
struct SampleFactors {
    std::uint64_t curvedSamples = 0;  // FramePlan::curvedSamples
    std::uint64_t rayBounces = 0;     // RayScene::bounces; 0: no draw traces rays
    std::uint64_t lobePaths = 1;      // the greater one of a RayScene
};

// The fields of a request that determine the size of a frame; see Pass::knobs().
inline constexpr std::string_view kKnobsOfTheFrame = "/width, /height";

}  // namespace clerestory
