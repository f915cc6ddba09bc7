// Stored environment maps: prefiltered, blurred where a material requests it, and kept resident.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Returns the prefiltered map that lights the scene; kNoTarget if its intensity is 0.
TargetId environmentTarget(ViewContext& context);

// Returns the prefiltered, optionally blurred map; adds its passes unless it is resident.
TargetId mapTarget(ViewContext& context, const EnvironmentMap& map, const MapBlur& blur = {});

// Adds the passes that blur the captured cube `source`, or the stored `map` if `source` is
// kNoTarget. faceSize: texels. Returns the target with the result and all its levels.
TargetId addBlur(ViewContext& context, const Subject& subject, const MapBlur& blur,
                 std::uint32_t faceSize, std::uint32_t generation, TargetId source,
                 const std::string& map = {});

}  // namespace clerestory
