#include "reference/lights.h"

namespace clerestory::reference {
namespace {

// As in shaders/include/optics.glsl: the minimum distance is 1 cm, and a spot's edge has a minimum
// width in the cosine.
constexpr double kMinDistanceSquared = 1e-4;
constexpr double kMinConeWidth = 1e-3;

double areaOf(const SceneGeometry::Triangle& t) {
    return 0.5 * glm::length(glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a),
                                        glm::dvec3(t.c) - glm::dvec3(t.a)));
}

}  // namespace

std::vector<PunctualLight> collectPunctualLights(const Scene& scene, const Pose& pose,
                                                 const glm::dvec3& origin,
                                                 const EnvironmentMap& environment,
                                                 const glm::dmat3& worldFromMap,
                                                 double environmentIntensity) {
    std::vector<PunctualLight> lights;
    for (const Light& light : scene.lights) {
        if (!(greatest(light.intensity) > 0.0)) continue;
        const glm::dmat4 m = light.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[light.node];
        lights.push_back({.kind = light.kind,
                          .position = glm::dvec3(m[3]) - origin,
                          .toLight = unitOr(glm::dvec3(m[2]), glm::dvec3(0, 0, 1)),
                          .intensity = light.intensity,
                          .range = light.range,
                          .cosInner = std::cos(double(light.innerConeAngle)),
                          .cosOuter = std::cos(double(light.outerConeAngle))});
    }
    if (environment.sun) {
        const glm::dvec3 irradiance =
            glm::dvec3(environment.sun->irradiance) * environmentIntensity;
        if (greatest(irradiance) > 0.0) {
            lights.push_back({.kind = LightKind::directional,
                              .toLight = worldFromMap * glm::dvec3(environment.sun->toSun),
                              .intensity = irradiance});
        }
    }
    return lights;
}

LightSample evalLight(const PunctualLight& light, const glm::dvec3& position) {
    if (light.kind == LightKind::directional) {
        return {light.toLight, std::numeric_limits<double>::infinity(), light.intensity};
    }
    const glm::dvec3 offset = light.position - position;
    LightSample sample;
    sample.distance = glm::length(offset);
    sample.toLight = unitOr(offset, light.toLight);
    double attenuation = 1.0 / std::max(sample.distance * sample.distance, kMinDistanceSquared);
    if (light.range > 0.0) {
        const double relative = std::min(sample.distance / light.range, 1.0);
        attenuation *= 1.0 - relative * relative * relative * relative;
    }
    if (light.kind == LightKind::spot) {
        const double width = std::max(light.cosInner - light.cosOuter, kMinConeWidth);
        const double within = std::clamp(
            (glm::dot(sample.toLight, light.toLight) - light.cosOuter) / width, 0.0, 1.0);
        attenuation *= within * within;
    }
    sample.irradiance = light.intensity * attenuation;
    return sample;
}

Emitters::Emitters(const SceneGeometry& geometry) : geometry_(geometry) {
    const auto& all = geometry.triangles();
    double sum = 0.0;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        const Surface& surface = geometry.surfaceOf(all[i]);
        if (!surface.emitter || !geometry.emissionEnabled()) continue;
        const double area = areaOf(all[i]);
        const double flux =
            area * luminance(glm::dvec3(emittedRadiance(geometry.materialOf(surface))));
        if (!(flux > 0.0)) continue;
        triangles_.push_back({i, sum, flux / area});
        sum += flux;
    }
    for (Entry& t : triangles_) {
        t.cdf /= sum;
        t.pdf /= sum;
    }
}

Emitters::Sample Emitters::sample(double uTriangle, const glm::dvec2& uPosition) const {
    const auto next = std::upper_bound(triangles_.begin(), triangles_.end(), uTriangle,
                                       [](double w, const Entry& t) { return w < t.cdf; });
    const Entry& chosen = *std::prev(next);  // the first cdf is 0
    // Uniform over the triangle (Turk 1990).
    const double root = std::sqrt(uPosition.x);
    const SceneGeometry::Triangle& t = geometry_.triangles()[chosen.triangle];
    Sample c{chosen.triangle, root * (1.0 - uPosition.y), root * uPosition.y, glm::dvec3(0.0)};
    c.position =
        glm::dvec3(t.a) * (1.0 - root) + glm::dvec3(t.b) * c.weightB + glm::dvec3(t.c) * c.weightC;
    return c;
}

double Emitters::pdf(std::uint32_t triangle, const glm::dvec3& direction, double distance) const {
    const auto found =
        std::lower_bound(triangles_.begin(), triangles_.end(), triangle,
                         [](const Entry& t, std::uint32_t n) { return t.triangle < n; });
    if (found == triangles_.end() || found->triangle != triangle) return 0.0;
    const SceneGeometry::Triangle& t = geometry_.triangles()[triangle];
    const glm::dvec3 normal =
        unitOr(glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a)),
               -direction);
    const double cosine = std::abs(glm::dot(normal, direction));
    return cosine > 1e-9 ? found->pdf * distance * distance / cosine : 0.0;
}

}  // namespace clerestory::reference
