#include "plan/visibility/lighting.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

float brightest(const glm::vec3& c) {
    return std::max({c.x, c.y, c.z});
}

// Upper bound of the irradiance in the box; 0 if the light cannot reach it.
double strengthAt(const PlacedLight& light, const glm::dvec3& eye, const Bounds& box) {
    if (light.kind == LightKind::directional) return brightest(light.intensity);
    const glm::dvec3 position = light.position - eye;
    const glm::dvec3 nearest = glm::clamp(position, glm::dvec3(box.min), glm::dvec3(box.max));
    const double distance = glm::length(nearest - position);
    if (light.range > 0.0f && distance >= light.range) return 0.0;
    if (light.kind == LightKind::spot) {
        // Bounding sphere against cone: outside if the angle from the axis to the centre exceeds
        // the half angle of the cone plus the angular radius of the sphere.
        const glm::dvec3 toCenter = glm::dvec3(box.center()) - position;
        const double radius = 0.5 * box.diagonal(), length = glm::length(toCenter);
        if (length > radius) {
            const double cosine =
                std::clamp(glm::dot(toCenter / length, -glm::dvec3(light.toLight)), -1.0, 1.0);
            const double angle = std::acos(cosine) - std::asin(radius / length);
            if (angle > std::acos(std::clamp<double>(light.cosOuter, -1.0, 1.0)) + 1e-6) return 0.0;
        }
    }
    constexpr double kNearest = 1e-4;  // square metres; finite for a light inside the box
    return brightest(light.intensity) / std::max(kNearest, distance * distance);
}

}  // namespace

std::vector<PlacedLight> placedLights(const std::vector<Light>& lights, const Pose& pose,
                                      const EnvironmentMap& environment,
                                      const glm::dmat3& worldFromMap, float environmentIntensity) {
    std::vector<PlacedLight> placed;
    for (const Light& light : lights) {
        if (placed.size() + 1 >= kMaxLights) break;
        if (!(brightest(light.intensity) > 0.0f)) continue;
        const glm::dmat4 m = placeOf(light, pose);
        const glm::dvec3 back(m[2]);
        const double length = glm::length(back);
        placed.push_back(
            {.kind = light.kind,
             .position = glm::dvec3(m[3]),
             .toLight = length > 0.0 ? glm::vec3(back / length) : glm::vec3(0.0f, 0.0f, 1.0f),
             .intensity = light.intensity,
             .range = light.range,
             .cosInner = std::cos(light.innerConeAngle),
             .cosOuter = std::cos(light.outerConeAngle),
             .radius = light.radius});
    }
    if (environment.sun && brightest(environment.sun->irradiance) * environmentIntensity > 0.0f) {
        placed.push_back({.kind = LightKind::directional,
                          .toLight = glm::vec3(worldFromMap * glm::dvec3(environment.sun->toSun)),
                          .intensity = environment.sun->irradiance * environmentIntensity});
    }
    return placed;
}

// The square of a light's mean distance from a ball's inside is about that from its centre plus a
// third of its radius squared.
double meanIrradiance(const PlacedLight& light, const glm::dvec3& eye, const Bounds& box) {
    const double greatest = strengthAt(light, eye, box);
    if (greatest == 0.0 || light.kind == LightKind::directional) return greatest;
    const double radius = 0.5 * box.diagonal();
    const glm::dvec3 away = glm::dvec3(box.center()) - (light.position - eye);
    const double squared = glm::dot(away, away) + radius * radius / 3.0;
    return std::min(greatest, brightest(light.intensity) / std::max(squared, 1e-4));
}

LightList lightsReaching(const std::vector<PlacedLight>& lights, const glm::dvec3& eye,
                         const Bounds& box, std::uint32_t& reaching) {
    std::vector<std::pair<double, std::uint8_t>> found;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const double strength = strengthAt(lights[i], eye, box);
        if (strength > 0.0) found.emplace_back(strength, static_cast<std::uint8_t>(i));
    }
    reaching = static_cast<std::uint32_t>(found.size());
    if (found.size() > kMaxLightsPerDraw) {
        std::stable_sort(found.begin(), found.end(),
                         [](const auto& a, const auto& b) { return a.first > b.first; });
        found.resize(kMaxLightsPerDraw);
        std::sort(found.begin(), found.end(),
                  [](const auto& a, const auto& b) { return a.second < b.second; });
    }
    LightList list;
    for (const auto& [strength, index] : found) list.indices[list.count++] = index;
    return list;
}

std::vector<std::uint8_t> allLightsReaching(const std::vector<PlacedLight>& lights,
                                            const glm::dvec3& eye, const Bounds& box) {
    std::vector<std::uint8_t> found;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (strengthAt(lights[i], eye, box) > 0.0) found.push_back(static_cast<std::uint8_t>(i));
    }
    return found;
}

}  // namespace clerestory
