#include "passes/layer_flow.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// At most 85 rays for a pixel; see MeasureFlow::shadedSamples().
constexpr int kMaxSteps = 12, kMaxHalvings = 4;
constexpr double kProbe = 1.0 / 64.0;       // pixels between the rays that give the derivatives
constexpr double kTolerance = 1e-4;         // of the slope of a pixel
constexpr double kLongestStep = 1.0 / 4.0;  // of the height of the frame

// How far the ray of a pixel passes by the point.
struct Miss {
    glm::dvec2 pixel{0.0};
    glm::dvec3 direction{0.0};  // of the line, world
    glm::dvec3 by{0.0};         // world, perpendicular to the line
    double length = 0.0;        // of the whole way to where the line is closest
    double perDepth = 0.0;      // depthPerDistance() of the pixel
    double limit = 0.0;         // of `by` that is close enough
};

class Search {
public:
    Search(const FlowTarget& to, const ShownThere& shown, const glm::dvec3& point)
        : to_(to), shown_(shown), point_(point) {}

    std::optional<Miss> missAt(const glm::dvec2& pixel) const {
        return missOf(pixel, [&](const PixelRay& ray, double spread) {
            return to_.layers.lineAfter(to_.layer, ray, spread, shown_.seen.instance, shown_.faces);
        });
    }

    // At the place of the surface, without a ray to it.
    std::optional<Miss> missAtSurface(const glm::dvec2& pixel) const {
        return missOf(pixel, [&](const PixelRay& ray, double spread) {
            return to_.layers.lineAfter(to_.layer, {ray, shown_.seen, spread}, shown_.faces);
        });
    }

    // The step in pixels to where the linearised miss is 0.
    std::optional<glm::dvec2> stepFrom(const Miss& here) const {
        const glm::dvec3& d = here.direction;
        const glm::dvec3 other = std::abs(d.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 u = glm::normalize(glm::cross(d, other)), v = glm::cross(d, u);
        const auto inPlane = [&](const glm::dvec3& a) {
            return glm::dvec2(glm::dot(a, u), glm::dot(a, v));
        };
        const auto derivative = [&](const glm::dvec2& way) -> std::optional<glm::dvec2> {
            for (const double probe : {kProbe, -kProbe}) {
                if (const auto there = missAt(here.pixel + probe * way)) {
                    return inPlane(there->by - here.by) / probe;
                }
            }
            return std::nullopt;
        };
        const auto x = derivative({1.0, 0.0}), y = derivative({0.0, 1.0});
        if (!x || !y) return std::nullopt;
        const glm::dmat2 jacobian(*x, *y);
        glm::dvec2 step = -(glm::inverse(jacobian) * inPlane(here.by));
        const double length = glm::length(step), longest = kLongestStep * to_.projection.height;
        if (!std::isfinite(length)) return std::nullopt;
        if (length > longest) step *= longest / length;
        return step;
    }

private:
    // lineOf(ray, spread) -> the line of the pixel's ray.
    template <class LineOf>
    std::optional<Miss> missOf(const glm::dvec2& pixel, const LineOf& lineOf) const {
        const auto ray = rayThrough(to_.projection, pixel);
        if (!ray) return std::nullopt;
        const double spread = spreadAt(to_.projection, pixel, *ray);
        const std::optional<LayerRays::Line> line = lineOf(*ray, spread);
        if (!line) return std::nullopt;
        const glm::dvec3 towards = point_ - line->start;
        const double along = glm::dot(towards, line->direction);
        if (!(along > 0.0)) return std::nullopt;
        Miss miss{
            .pixel = pixel, .direction = line->direction, .by = towards - along * line->direction};
        miss.length = line->length + along;
        miss.perDepth = depthPerDistance(to_.projection, glm::normalize(ray->direction));
        miss.limit = kTolerance * std::max(spread, 1e-9) * miss.length;
        return miss;
    }

    const FlowTarget& to_;
    const ShownThere& shown_;
    glm::dvec3 point_;
};

}  // namespace

double spreadAt(const Projection& projection, const glm::dvec2& pixel, const PixelRay& ray) {
    const auto neighbour = rayThrough(projection, pixel + glm::dvec2(0.5, 0.0));
    if (!neighbour) return 0.0;
    return 2.0 * glm::length(glm::normalize(neighbour->direction) - glm::normalize(ray.direction));
}

std::optional<ProjectedPoint> shownAt(const FlowTarget& to, const ShownThere& shown,
                                      const glm::dvec3& point, const glm::dvec2& start) {
    const Search search(to, shown, point);
    std::optional<Miss> here = search.missAtSurface(start);
    for (int i = 0; here && i < kMaxSteps; ++i) {
        if (glm::length(here->by) <= here->limit) {
            return ProjectedPoint{here->pixel, here->length * here->perDepth};
        }
        const auto step = search.stepFrom(*here);
        if (!step) return std::nullopt;
        std::optional<Miss> nearer;
        double share = 1.0;
        for (int k = 0; k <= kMaxHalvings && !nearer; ++k, share *= 0.5) {
            nearer = search.missAt(here->pixel + share * *step);
            if (nearer && glm::length(nearer->by) >= glm::length(here->by)) nearer.reset();
        }
        here = nearer;
    }
    return std::nullopt;
}

}  // namespace clerestory
