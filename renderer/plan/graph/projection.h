// Pixels and world points of a requested view under any lens, in double precision. Pixels are
// counted from the upper left corner, y downwards; the first pixel is centred at 0.5, 0.5.
//
//     const PixelRay ray = *rayThrough(projection, {x + 0.5, y + 0.5});
//     const glm::dvec3 point = ray.origin + distance * ray.direction;
//     projected(projection, point)->pixel;  // again {x + 0.5, y + 0.5}
#pragma once

#include "plan/graph/draw.h"
#include "plan/lens/lens.h"

#include <optional>

namespace clerestory {

struct Projection {
    View view;
    std::optional<Lens> lens;  // none: the projection matrix of the view
    std::uint32_t width = 1, height = 1;
    bool operator==(const Projection&) const = default;
};

struct PixelRay {
    glm::dvec3 origin{0.0};                // world
    glm::dvec3 direction{0.0, 0.0, -1.0};  // world, any length but 0
};
// None where the lens shows nothing.
std::optional<PixelRay> rayThrough(const Projection& projection, const glm::dvec2& pixel);

struct ProjectedPoint {
    glm::dvec2 pixel{0.0};  // may be outside of the frame
    double depth = 0.0;     // as the channel depth holds it
};
// None for a point behind the camera, or in a direction that the lens does not show.
std::optional<ProjectedPoint> projected(const Projection& projection, const glm::dvec3& world);

// What the channel depth holds for a point at a distance of 1 along a ray; direction: world, unit.
double depthPerDistance(const Projection& projection, const glm::dvec3& direction);

// The way from one pixel to another: the shorter one round a panorama that closes.
glm::dvec2 displacement(const Projection& projection, const glm::dvec2& from, const glm::dvec2& to);

}  // namespace clerestory
