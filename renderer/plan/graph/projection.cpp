#include "plan/graph/projection.h"

#include <cmath>
#include <numbers>

namespace clerestory {
namespace {

// Of the whole picture, y upwards.
glm::dvec2 clipOf(const Projection& p, const glm::dvec2& pixel) {
    return {2.0 * pixel.x / p.width - 1.0, 1.0 - 2.0 * pixel.y / p.height};
}
glm::dvec2 pixelAt(const Projection& p, const glm::dvec2& clip) {
    return {0.5 * (1.0 + clip.x) * p.width, 0.5 * (1.0 - clip.y) * p.height};
}

}  // namespace

std::optional<PixelRay> rayThrough(const Projection& p, const glm::dvec2& pixel) {
    const glm::dmat3 worldFromView = glm::transpose(glm::dmat3(p.view.viewFromWorld));  // rotation
    if (p.lens) {
        const auto ray = rayOf(*p.lens, pixel);
        if (!ray) return std::nullopt;
        return PixelRay{p.view.eye, worldFromView * *ray};
    }
    const glm::dmat4& m = p.view.clipFromView;
    const glm::dvec2 clip = clipOf(p, pixel);
    if (p.view.orthographic) {
        const glm::dvec3 at(clip.x / m[0][0], clip.y / m[1][1], 0.0);
        return PixelRay{p.view.eye + worldFromView * at, -worldFromView[2]};
    }
    const glm::dvec3 ahead((clip.x + m[2][0]) / m[0][0], (clip.y + m[2][1]) / m[1][1], -1.0);
    return PixelRay{p.view.eye, worldFromView * ahead};
}

std::optional<ProjectedPoint> projected(const Projection& p, const glm::dvec3& world) {
    // Relative to the eye first: far from the world's origin nothing is lost.
    const glm::dvec3 at = glm::dmat3(p.view.viewFromWorld) * (world - p.view.eye);
    if (p.lens) {
        const double distance = glm::length(at);
        if (!(distance > 0.0)) return std::nullopt;
        const auto pixel = pixelOf(*p.lens, at);
        if (!pixel) return std::nullopt;
        return ProjectedPoint{*pixel, distance * depthPerDistance(*p.lens, at / distance)};
    }
    if (!(at.z < 0.0)) return std::nullopt;
    const glm::dmat4& m = p.view.clipFromView;
    const glm::dvec2 clip =
        p.view.orthographic
            ? glm::dvec2(m[0][0] * at.x, m[1][1] * at.y)
            : glm::dvec2(m[0][0] * at.x + m[2][0] * at.z, m[1][1] * at.y + m[2][1] * at.z) / -at.z;
    return ProjectedPoint{pixelAt(p, clip), -at.z};
}

double depthPerDistance(const Projection& p, const glm::dvec3& direction) {
    const glm::dvec3 inView = glm::dmat3(p.view.viewFromWorld) * direction;
    return p.lens ? depthPerDistance(*p.lens, inView) : -inView.z;
}

glm::dvec2 displacement(const Projection& p, const glm::dvec2& from, const glm::dvec2& to) {
    glm::dvec2 way = to - from;
    const auto* panorama = p.lens ? std::get_if<EquirectangularLens>(&p.lens->model) : nullptr;
    if (panorama && panorama->longitude > 2.0 * std::numbers::pi - 1e-9) {
        way.x -= p.width * std::round(way.x / p.width);
    }
    return way;
}

}  // namespace clerestory
