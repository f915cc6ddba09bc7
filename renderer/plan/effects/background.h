// What the requested view shows where it sees no surface (FrameRequest::background).
#pragma once

#include "plan/effects/view_context.h"

namespace clerestory {

// Plans the requested view with its background. Before a transparent one a view without glass is
// drawn once, with the share that surfaces cover as alpha. A view with glass is drawn twice, before
// black and before white: how much of the background a pixel shows is their difference, whatever
// the light has passed. `radiance` becomes the picture, whose alpha is that of the background.
SeenView planBackground(ViewContext& context, ViewTask root,
                        const std::optional<BackgroundRequest>& background, TargetId& radiance);

void explainBackground(FramePlan& plan, const std::optional<BackgroundRequest>& background);

}  // namespace clerestory
