// How much a frame shades, and refusing what is more than somebody allows: pixels x samples over
// all passes of the plan.
//
// Does not: predict milliseconds; that is plan/cost/cost.h.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// Samples that a pass shades: texels of what it draws into, times the samples of each; of a map the
// directions that each texel adds up; where rays are followed or a rough mirror adds up directions,
// as if every pixel did so.
std::uint64_t shadedSamples(const FramePlan& plan, const Pass& pass);
std::uint64_t shadedSamples(const FramePlan& plan);

// What every plan of the request shades, whatever the scene.
std::uint64_t leastShadedSamples(const FrameRequest& request);

// Throw InvalidRequest, which names the knobs that take most and what is allowed, when it is more
// than `most` samples; 0: any. A plan's maps that are resident cost nothing, so what is refused
// cold may be drawn when somebody else has had them drawn.
void requireAffordable(const FrameRequest& request, std::uint64_t most);
void requireAffordable(const FramePlan& plan, std::uint64_t most);

}  // namespace clerestory
