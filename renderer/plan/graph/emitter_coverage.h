// Small glowing surfaces by the share that they cover of each pixel. graph/pass.h describes the
// members that every pass type has.
#pragma once

#include "plan/graph/draw.h"
#include "plan/graph/sample_costs.h"
#include "plan/graph/target.h"
#include "scene/hash.h"

#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// Changes the picture in the target, one sample in the middle of each pixel, where emitters end: a
// flame that is smaller than a pixel is either missing there or as bright as if it filled the
// pixel. The shares are computed from the triangles.
struct EmitterCoverage {
    // Triangles of one radiance.
    struct Emitter {
        std::uint32_t instance = 0;
        std::uint32_t firstIndex = 0, indexCount = 0;  // as those of a Draw
        glm::vec3 radiance{0.0f};
        bool doubleSided = false;
        bool operator==(const Emitter&) const = default;
    };
    View view;  // of the picture
    std::vector<Emitter> emitters;
    bool transparent = false;  // alpha is a coverage

    std::string_view kind() const { return "emitterCoverage"; }
    std::vector<TargetId> reads() const { return {}; }
    std::string_view knobs() const { return "/accuracy/emitterCoverage"; }
    std::uint64_t shadedSamples(const TargetSpec&, const SampleFactors&) const { return 0; }
    friend void addTo(PlanHash&, const EmitterCoverage&, const Stage&) {}  // of frames only
    bool operator==(const EmitterCoverage&) const = default;
};

}  // namespace clerestory
