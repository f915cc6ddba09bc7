#include "passes/layer_rays.h"

#include <algorithm>

namespace clerestory {
namespace {

// How far from a surface a ray starts; see offsetRayOrigin() in ray.glsl. start: from the origin.
glm::dvec3 offset(const glm::dvec3& start, const glm::dvec3& normal) {
    constexpr double kPerCoordinate = 2e-6;
    const double reach = std::max({std::abs(start.x), std::abs(start.y), std::abs(start.z)});
    return start + kPerCoordinate * reach * normal;
}

// mirroredAt() in ray.glsl: on the side of the surface, whatever its bumps are.
glm::dvec3 mirrored(const glm::dvec3& direction, const glm::dvec3& normal,
                    const glm::dvec3& ofSurface) {
    const glm::dvec3 away = glm::reflect(direction, normal);
    return glm::normalize(away + std::max(1e-3 - glm::dot(away, ofSurface), 0.0) * ofSurface);
}

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

const Material& LayerRays::materialOf(Index instance) const {
    return materials_.material(scene_, materials_.materialOf(scene_, instance));
}

bool LayerRays::hasBumps(Index instance) const {
    const Material& material = materialOf(instance);
    return material.normalTexture.present() && material.normalScale != 0.0f;
}

LayerRays::Met LayerRays::metAt(const PixelView& pixel) const {
    const PixelRay& ray = pixel.ray;
    Met met{.point = pixel.seen, .position = positionOf(scene_, pose_, pixel.seen)};
    const glm::dvec3 outer = normalOf(scene_, pose_, pixel.seen);
    met.front = glm::dot(outer, ray.direction) < 0.0;
    met.normal = met.bumped = met.front ? outer : -outer;
    met.length = glm::length(met.position - ray.origin);
    if (!hasBumps(pixel.seen.instance)) return met;
    const glm::vec3 start(offset(relative(met.position), met.normal));
    const auto hit = tracer_.pointAlong(start, glm::vec3(glm::normalize(ray.direction)),
                                        static_cast<float>(pixel.spread * met.length),
                                        static_cast<float>(pixel.spread));
    if (hit && hit->instance == pixel.seen.instance) met.bumped = hit->normal;
    return met;
}

std::optional<LayerRays::Met> LayerRays::next(const Met& from, const glm::dvec3& direction,
                                              double spread) const {
    const double side = glm::dot(direction, from.normal) < 0.0 ? -1.0 : 1.0;
    const glm::dvec3 start = offset(relative(from.position), side * from.normal);
    const auto hit =
        tracer_.pointAlong(glm::vec3(start), glm::vec3(direction),
                           static_cast<float>(spread * from.length), static_cast<float>(spread));
    if (!hit) return std::nullopt;
    // The tree gives the triangle; the point on it is computed in double precision.
    Met met{.point = pointAlong(scene_, pose_, hit->instance, 3 * hit->triangle, from.position,
                                direction),
            .front = hit->front,
            .baseColor = hit->baseColor};
    met.position = positionOf(scene_, pose_, met.point);
    met.normal = (met.front ? 1.0 : -1.0) * normalOf(scene_, pose_, met.point);
    met.bumped = hasBumps(hit->instance) ? glm::dvec3(hit->normal) : met.normal;
    met.length = from.length + glm::length(met.position - from.position);
    return met;
}

glm::dvec3 LayerRays::throughGlass(const Met& met, const glm::dvec3& direction) const {
    if (glassOf(met.point.instance) == Glass::pane) return direction;
    const double ior = std::max(1.0, static_cast<double>(materialOf(met.point.instance).ior));
    const glm::dvec3 normal = glm::dot(met.bumped, direction) < 0.0 ? met.bumped : met.normal;
    const glm::dvec3 bent = glm::refract(direction, normal, met.front ? 1.0 / ior : ior);
    // Total reflection.
    if (glm::dot(bent, bent) < 0.5) return mirrored(direction, normal, met.normal);
    return glm::normalize(bent);
}

glm::dvec3 LayerRays::turned(OutputLayer layer, const Met& met, const glm::dvec3& direction) const {
    return layer == OutputLayer::reflected ? mirrored(direction, met.bumped, met.normal)
                                           : throughGlass(met, direction);
}

std::optional<LayerRays::Shown> LayerRays::shown(OutputLayer layer, const PixelView& pixel) const {
    const auto turnsRays = [&](const Met& met) {
        return layer == OutputLayer::refracted && glassOf(met.point.instance) != Glass::none;
    };
    Met here = metAt(pixel);
    if (layer == OutputLayer::refracted && !turnsRays(here)) return std::nullopt;
    glm::dvec3 direction = glm::normalize(pixel.ray.direction);
    for (std::uint32_t faces = 1; faces <= kMaxFaces; ++faces) {
        direction = turned(layer, here, direction);
        const auto met = next(here, direction, pixel.spread);
        if (!met) return std::nullopt;
        if (!turnsRays(*met)) return Shown{*met, faces};
        here = *met;
    }
    return std::nullopt;
}

void LayerRays::instancesAlong(OutputLayer layer, const PixelView& pixel,
                               std::vector<Index>& instances) const {
    instances.clear();
    Met here = metAt(pixel);
    glm::dvec3 direction = turned(layer, here, glm::normalize(pixel.ray.direction));
    std::uint32_t faces = 1;
    for (std::uint32_t passed = 0; passed < kMaxSurfaces; ++passed) {
        const auto met = next(here, direction, pixel.spread);
        if (!met) return;
        here = *met;
        const Index instance = here.point.instance;
        if (layer == OutputLayer::refracted && glassOf(instance) != Glass::none) {
            if (++faces > kMaxFaces) return;
            direction = turned(layer, here, direction);
        } else if (std::ranges::find(instances, instance) == instances.end()) {
            instances.push_back(instance);
        }
    }
}

std::optional<LayerRays::Line> LayerRays::lineFrom(OutputLayer layer, Met here,
                                                   glm::dvec3 direction, double spread,
                                                   std::uint32_t faces) const {
    direction = turned(layer, here, direction);
    std::uint32_t left = faces - 1;
    for (std::uint32_t passed = 0; passed < kMaxSurfaces && left > 0; ++passed) {
        const auto met = next(here, direction, spread);
        if (!met) return std::nullopt;
        here = *met;
        if (glassOf(here.point.instance) == Glass::none) continue;
        direction = turned(layer, here, direction);
        --left;
    }
    if (left > 0) return std::nullopt;
    return Line{here.position, direction, here.length};
}

std::optional<LayerRays::Line> LayerRays::lineAfter(OutputLayer layer, const PixelView& pixel,
                                                    std::uint32_t faces) const {
    return lineFrom(layer, metAt(pixel), glm::normalize(pixel.ray.direction), pixel.spread, faces);
}

std::optional<LayerRays::Line> LayerRays::lineAfter(OutputLayer layer, const PixelRay& ray,
                                                    double spread, Index first,
                                                    std::uint32_t faces) const {
    Met here{.position = ray.origin};
    const glm::dvec3 direction = glm::normalize(ray.direction);
    for (std::uint32_t passed = 0; passed < kMaxSurfaces; ++passed) {
        const auto met = next(here, direction, spread);
        if (!met) return std::nullopt;
        here = *met;
        if (here.point.instance == first) return lineFrom(layer, here, direction, spread, faces);
    }
    return std::nullopt;
}

}  // namespace clerestory
