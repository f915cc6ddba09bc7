// From the clusters of a scene to the draws of one view: culled, classed, ordered.
#pragma once

#include "plan/frame_plan.h"

namespace clerestory {

struct ViewDraws {
    std::vector<Draw> depth;    // opaque and not masked, near to far, merged: for a depth prepass
    std::vector<Draw> opaque;   // near to far, or by state when `depth` will be used; masked last
    std::vector<Draw> blended;  // far to near
    double overdraw = 0.0;      // predicted layers of opaque surface over the whole picture
    std::uint64_t clusters = 0, culled = 0;
    std::uint32_t mostLights = 0;  // the most that reach one draw, before the limit
    bool anyLit = false, anyEmissive = false, emissiveInScene = false, glassInScene = false;
};

// Layers of opaque surface above which drawing depth first pays (measured on the software
// rasteriser: Sponza 198 -> 127 ms at some five layers; nothing gained at one).
inline constexpr double kPrepassOverdraw = 1.2;

ViewDraws drawsFor(const Scene& scene, const Pose& pose, const View& view, const Effects& effects,
                   const std::vector<PlacedLight>& lights);

}  // namespace clerestory
