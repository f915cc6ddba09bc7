// Stored environment maps: prefiltered, blurred where a material requests it, and kept resident.
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// The prefiltered map that lights the scene; kNoTarget when its intensity is 0.
TargetId environmentTarget(ViewContext& context);

// A prefiltered map of any name; adds its passes unless it is resident.
TargetId mapTarget(ViewContext& context, const EnvironmentMap& map, const MapBlur& blur = {});

// Adds the passes that blur `source`, a captured cube, or, where that is kNoTarget, the stored
// `map`. Returns the target that holds the result with all its levels.
TargetId addBlur(ViewContext& context, const std::string& name, const MapBlur& blur,
                 std::uint32_t faceSize, std::uint32_t generation, TargetId source,
                 const std::string& map = {});

}  // namespace clerestory
