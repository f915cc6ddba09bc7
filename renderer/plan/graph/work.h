// The number of samples that a frame shades, summed over all passes of its plan, and the check
// against a limit.
//
// Does not predict milliseconds; see plan/cost/cost.h.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Samples that a pass shades: texels of its target times samples per texel, or times the directions
// per texel of a map; of Supersampling, of the greatest share of pixels that may have further
// samples. If a draw traces rays or averages directions, every pixel counts as if it did.
std::uint64_t shadedSamples(const FramePlan& plan, const Pass& pass);
std::uint64_t shadedSamples(const FramePlan& plan);

// Lower bound of the samples of any plan for the request, for any scene.
std::uint64_t minShadedSamples(const FrameRequest& request);

// Throw InvalidRequest, which names the fields with the largest cost and the limit, if there are
// more than `maxSamples` samples; 0: no limit. Resident maps cost nothing, so a request can be
// rejected before its maps are resident and accepted afterwards.
void requireAffordable(const FrameRequest& request, std::uint64_t maxSamples);
void requireAffordable(const FramePlan& plan, std::uint64_t maxSamples);

}  // namespace clerestory
