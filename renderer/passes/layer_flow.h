// Where a mirror or glass of another frame shows a point.
//
//     const FlowTarget to{projection, layers, OutputLayer::reflected};
//     if (auto shown = shownAt(to, {seen, faces}, point, start)) shown->pixel;
#pragma once

#include "passes/layer_rays.h"

namespace clerestory {

// The other frame: layers has its pose.
struct FlowTarget {
    const Projection& projection;
    const LayerRays& layers;
    OutputLayer layer = OutputLayer::reflected;
};

// The point of a mirror or glass where it shows something in this frame, and the faces that turn
// the ray; see LayerRays::Shown.
struct ShownThere {
    SurfacePoint seen;
    std::uint32_t faces = 1;
};

// Slope between the rays of neighbouring pixels.
double spreadAt(const Projection& projection, const glm::dvec2& pixel, const PixelRay& ray);

// The pixel whose ray, turned by the same instance and as many faces, passes through `point`
// (world), and the length of the way as depth. Surfaces that hide the point are ignored. Begins at
// `shown.seen`, `start` in the other frame, which is the result if nothing has moved. Newton's
// method; none if it does not converge, for example because the mirror has no such pixel.
std::optional<ProjectedPoint> shownAt(const FlowTarget& to, const ShownThere& shown,
                                      const glm::dvec3& point, const glm::dvec2& start);

}  // namespace clerestory
