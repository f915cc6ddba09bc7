#include "reference/lamps.h"

namespace clerestory::reference {
namespace {

// As the renderer has them (shaders/include/optics.glsl): a lamp nearer than 1 cm shines as from 1
// cm, and no spot's edge is sharper than this in the cosine.
constexpr double kMinDistanceSquared = 1e-4;
constexpr double kMinConeWidth = 1e-3;

double areaOf(const World::Triangle& t) {
    return 0.5 * glm::length(glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a),
                                        glm::dvec3(t.c) - glm::dvec3(t.a)));
}

}  // namespace

std::vector<Lamp> lampsOf(const Scene& scene, const Pose& pose, const glm::dvec3& origin,
                          const EnvironmentMap& environment, const glm::dmat3& worldFromMap,
                          double environmentIntensity) {
    std::vector<Lamp> lamps;
    for (const Light& light : scene.lights) {
        if (!(greatest(light.intensity) > 0.0)) continue;
        const glm::dmat4 m = light.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[light.node];
        lamps.push_back({.kind = light.kind,
                         .place = glm::dvec3(m[3]) - origin,
                         .toLamp = unitOr(glm::dvec3(m[2]), glm::dvec3(0, 0, 1)),
                         .intensity = light.intensity,
                         .range = light.range,
                         .cosInner = std::cos(double(light.innerConeAngle)),
                         .cosOuter = std::cos(double(light.outerConeAngle))});
    }
    if (environment.sun) {
        const glm::dvec3 irradiance =
            glm::dvec3(environment.sun->irradiance) * environmentIntensity;
        if (greatest(irradiance) > 0.0) {
            lamps.push_back({.kind = LightKind::directional,
                             .toLamp = worldFromMap * glm::dvec3(environment.sun->toSun),
                             .intensity = irradiance});
        }
    }
    return lamps;
}

LampLight lightAt(const Lamp& lamp, const glm::dvec3& place) {
    if (lamp.kind == LightKind::directional) {
        return {lamp.toLamp, std::numeric_limits<double>::infinity(), lamp.intensity};
    }
    const glm::dvec3 way = lamp.place - place;
    LampLight light;
    light.distance = glm::length(way);
    light.toLamp = unitOr(way, lamp.toLamp);
    double share = 1.0 / std::max(light.distance * light.distance, kMinDistanceSquared);
    if (lamp.range > 0.0) {
        const double part = std::min(light.distance / lamp.range, 1.0);
        share *= 1.0 - part * part * part * part;
    }
    if (lamp.kind == LightKind::spot) {
        const double width = std::max(lamp.cosInner - lamp.cosOuter, kMinConeWidth);
        const double within =
            std::clamp((glm::dot(light.toLamp, lamp.toLamp) - lamp.cosOuter) / width, 0.0, 1.0);
        share *= within * within;
    }
    light.irradiance = lamp.intensity * share;
    return light;
}

Emitters::Emitters(const World& world) : world_(world) {
    const auto& all = world.triangles();
    double sum = 0.0;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        const Surface& surface = world.surfaceOf(all[i]);
        if (!surface.emitter || !world.emits()) continue;
        const double area = areaOf(all[i]);
        const double light =
            area * luminance(glm::dvec3(emittedRadiance(world.materialOf(surface))));
        if (!(light > 0.0)) continue;
        triangles_.push_back({i, sum, light / area});
        sum += light;
    }
    for (Glowing& t : triangles_) {
        t.upTo /= sum;
        t.density /= sum;
    }
}

Emitters::Choice Emitters::choose(double which, const glm::dvec2& where) const {
    const auto next = std::upper_bound(triangles_.begin(), triangles_.end(), which,
                                       [](double w, const Glowing& t) { return w < t.upTo; });
    const Glowing& chosen = *std::prev(next);  // the first begins at 0
    // Uniform over the triangle (Turk 1990).
    const double root = std::sqrt(where.x);
    const World::Triangle& t = world_.triangles()[chosen.triangle];
    Choice c{chosen.triangle, root * (1.0 - where.y), root * where.y, glm::dvec3(0.0)};
    c.place =
        glm::dvec3(t.a) * (1.0 - root) + glm::dvec3(t.b) * c.weightB + glm::dvec3(t.c) * c.weightC;
    return c;
}

double Emitters::density(std::uint32_t triangle, const glm::dvec3& along, double distance) const {
    const auto found =
        std::lower_bound(triangles_.begin(), triangles_.end(), triangle,
                         [](const Glowing& t, std::uint32_t n) { return t.triangle < n; });
    if (found == triangles_.end() || found->triangle != triangle) return 0.0;
    const World::Triangle& t = world_.triangles()[triangle];
    const glm::dvec3 normal = unitOr(
        glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a)), -along);
    const double cosine = std::abs(glm::dot(normal, along));
    return cosine > 1e-9 ? found->density * distance * distance / cosine : 0.0;
}

}  // namespace clerestory::reference
