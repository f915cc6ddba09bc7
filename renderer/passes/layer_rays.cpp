#include "passes/layer_rays.h"

#include <algorithm>

namespace clerestory {
namespace {

// How far from a surface a ray starts, per greatest coordinate; see offsetRayOrigin() in ray.glsl.
constexpr double kOffset = 2e-6;

}  // namespace

LayerRays::LayerRays(const Scene& scene, const Pose& pose, const FramePlan& plan,
                     const rays::Surroundings& surroundings, const glm::dvec3& origin)
    : scene_(scene),
      pose_(pose),
      plan_(plan),
      materials_{plan.materials, plan.rays->materialOfInstance, plan.rays->hidden},
      tracer_(surroundings),
      origin_(origin) {}

Glass LayerRays::glassOf(Index instance) const {
    return plan_.rays->instances[instance].glass;
}

LayerRays::Met LayerRays::metAt(const PixelRay& ray, const SurfacePoint& seen) const {
    Met met{.point = seen, .place = positionOf(scene_, pose_, seen)};
    const glm::dvec3 outer = normalOf(scene_, pose_, seen);
    met.front = glm::dot(outer, ray.direction) < 0.0;
    met.normal = met.front ? outer : -outer;
    met.length = glm::length(met.place - ray.origin);
    return met;
}

std::optional<LayerRays::Met> LayerRays::next(const Met& from, const glm::dvec3& direction,
                                              double spread) const {
    const glm::dvec3 relative = from.place - origin_;
    const double reach =
        std::max({std::abs(relative.x), std::abs(relative.y), std::abs(relative.z)});
    const double side = glm::dot(direction, from.normal) < 0.0 ? -1.0 : 1.0;
    const glm::dvec3 start = relative + side * kOffset * reach * from.normal;
    const auto hit =
        tracer_.pointAlong(glm::vec3(start), glm::vec3(direction),
                           static_cast<float>(spread * from.length), static_cast<float>(spread));
    if (!hit) return std::nullopt;
    // The tree gives the triangle; the point on it is computed in double precision.
    Met met{
        .point = pointAlong(scene_, pose_, hit->instance, 3 * hit->triangle, from.place, direction),
        .front = hit->front,
        .baseColor = hit->baseColor};
    met.place = positionOf(scene_, pose_, met.point);
    met.normal = (met.front ? 1.0 : -1.0) * normalOf(scene_, pose_, met.point);
    met.length = from.length + glm::length(met.place - from.place);
    return met;
}

std::optional<LayerRays::Met> LayerRays::reflected(const PixelRay& ray, const SurfacePoint& seen,
                                                   double spread) const {
    const Met mirror = metAt(ray, seen);
    return next(mirror, glm::reflect(glm::normalize(ray.direction), mirror.normal), spread);
}

glm::dvec3 LayerRays::beyond(const Met& met, const glm::dvec3& direction) const {
    if (glassOf(met.point.instance) == Glass::pane) return direction;
    const Index material = materials_.materialOf(scene_, met.point.instance);
    const double ior =
        std::max(1.0, static_cast<double>(materials_.material(scene_, material).ior));
    const glm::dvec3 bent = glm::refract(direction, met.normal, met.front ? 1.0 / ior : ior);
    // Total reflection.
    if (glm::dot(bent, bent) < 0.5) return glm::reflect(direction, met.normal);
    return glm::normalize(bent);
}

std::optional<LayerRays::Met> LayerRays::refracted(const PixelRay& ray, const SurfacePoint& seen,
                                                   double spread) const {
    Met here = metAt(ray, seen);
    glm::dvec3 direction = glm::normalize(ray.direction);
    for (int i = 0; i < kMaxInterfaces && glassOf(here.point.instance) != Glass::none; ++i) {
        direction = beyond(here, direction);
        const auto met = next(here, direction, spread);
        if (!met) return std::nullopt;
        here = *met;
    }
    const bool isGlass = glassOf(here.point.instance) != Glass::none;
    return isGlass ? std::nullopt : std::optional(here);
}

}  // namespace clerestory
