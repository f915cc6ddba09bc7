// Nearer pictures of suns. The picture of all that a sun reaches has texels of decimetres over a
// town; further pictures of what is near the observer have smaller ones. They follow it in steps,
// so that most frames of a moving camera draw none.
//
//     const Observer observer{.views = {view}, .pixel = 2.0 * std::tan(0.5 * yfov) / height};
//     const std::optional<MapSize> size = placeNearer(stage, shadows, whole, observer,
//     plan.lights);
#pragma once

#include "plan/effects/shadow_pictures.h"

#include <optional>
#include <vector>

namespace clerestory {

// What the requested views are seen from.
struct Observer {
    std::vector<View> views;  // from one place; several: tiles of a lens, which may have none
    double pixel = 0.0;       // of their angle, radians
};

// Sets LightShadow::nearer of the suns whose texels are much larger than pixels on the surfaces
// near the observer, in tiles to the right of the others. others: the size of the map of these.
// Returns the size of the map of both, the same for all observers, or nothing if no sun has nearer
// pictures. An orthographic view has none.
std::optional<MapSize> placeNearer(const Stage& stage, const std::vector<Shadow>& shadows,
                                   const MapSize& others, const Observer& observer,
                                   std::vector<PlacedLight>& lights);

}  // namespace clerestory
