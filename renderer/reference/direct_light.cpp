// Light that comes to a point straight from its sources: lamps, and, in full, glowing surfaces and
// the environment, chosen by chance and weighed against the turns that may find them as well
// (balance heuristic, Veach 1997).
#include "reference/fresnel.h"
#include "reference/path.h"

namespace clerestory::reference {
namespace {

constexpr int kMaxHoles = 64;  // surfaces that light passes on its way

double weighed(double chosen, double other) {
    return chosen / (chosen + other);
}

}  // namespace

glm::dvec3 PathTracer::arriving(Ray ray, bool throughGlass) const {
    if (!world_.anyClear()) return glm::dvec3(world_.blocked(ray) ? 0.0 : 1.0);
    glm::dvec3 share(1.0);
    Media media;
    for (int i = 0; i < kMaxHoles; ++i) {
        const std::optional<Hit> hit = world_.nearest(ray);
        if (!hit) return share;
        const Point p = world_.pointAt(*hit, ray.direction);
        if (media.count > 0) {
            const Material& m = *media.last().material;
            share *= absorbed(m.attenuationColor, m.attenuationDistance, hit->distance);
        }
        glm::dvec3 clear(1.0 - p.coverage);
        if (throughGlass && p.transmission > 0.0) {
            const double cosine = -glm::dot(p.normal, ray.direction);
            const double ior = std::max(1.0, double(p.material->ior));
            glm::dvec3 passed;
            if (p.surface->glass == Glass::pane) {
                const double inside = std::max(refractedCosine(cosine, ior), 1e-3);
                const Material& m = *p.material;
                passed =
                    p.baseColor * paneShares(cosine, ior,
                                             absorbed(m.attenuationColor, m.attenuationDistance,
                                                      p.thickness / inside))
                                      .transmitted;
            } else {
                // Not bent, so it comes out at the angle that it went in.
                passed = glm::dvec3(1.0 - fresnel(cosine, ior).mean());
                if (p.front) {
                    passed *= p.baseColor;
                    media.enter(p);
                } else {
                    media.leave(p);
                }
            }
            clear += p.coverage * p.transmission * (1.0 - p.metallic) * passed;
        }
        share *= clear;
        if (!(greatest(share) > 0.0)) return glm::dvec3(0.0);
        Ray next = World::leaving(p, ray.direction);
        next.farthest = ray.farthest - hit->distance;
        ray = next;
    }
    return glm::dvec3(0.0);
}

glm::dvec3 PathTracer::underLamps(Path& path, const Point& point, const Lobes& lobes,
                                  double diffuseShare) const {
    glm::dvec3 sum(0.0);
    // In full one of them is chosen, as likely as it would be bright without shadows.
    struct Chosen {
        LampLight light;
        glm::dvec3 reflected{0.0};
        double bright = 0.0;
    } chosen;
    double all = 0.0;
    double random =
        mode_ == ReferenceMode::full && !lighting_.lamps.empty() ? path.random.one() : 0;
    for (const Lamp& lamp : lighting_.lamps) {
        const LampLight light = lightAt(lamp, point.place);
        const double cosine = glm::dot(point.normal, light.toLamp);
        if (!(cosine > 0.0) || !(greatest(light.irradiance) > 0.0)) continue;
        const glm::dvec3 reflected =
            light.irradiance * cosine *
            lobes.underLamp(lobes.frame().toLocal(light.toLamp), diffuseShare, point.covered);
        sum += reflected;
        const double bright = luminance(reflected);
        if (mode_ == ReferenceMode::effects || !(bright > 0.0)) continue;
        all += bright;
        // One random number for all choices: what is left of it is uniform again.
        const double share = bright / all;
        if (random < share) {
            chosen = {light, reflected, bright};
            random /= share;
        } else {
            random = (random - share) / (1.0 - share);
        }
    }
    if (mode_ == ReferenceMode::effects) return sum;
    if (!(chosen.bright > 0.0) || glm::dot(chosen.light.toLamp, point.face) <= 0.0) {
        return glm::dvec3(0.0);
    }
    Ray ray = World::leaving(point, chosen.light.toLamp);
    ray.farthest = chosen.light.distance * (1.0 - 1e-6);
    return chosen.reflected * (all / chosen.bright) * arriving(ray, true);
}

glm::dvec3 PathTracer::underChosenLights(Path& path, const Point& point, const Lobes& lobes,
                                         double specularChance, double rest) const {
    // What of the light from `towards`, chosen with `density`, both lobes send to the eye.
    const auto reflected = [&](const glm::dvec3& towards, double density) {
        const glm::dvec3 l = lobes.frame().toLocal(towards);
        if (l.z <= 0.0 || glm::dot(towards, point.face) <= 0.0 || !(density > 0.0)) {
            return glm::dvec3(0.0);
        }
        glm::dvec3 sum(0.0);
        if (specularChance > 0.0) {
            sum += lobes.specularOf(l) * weighed(density, specularChance * lobes.densityOf(l));
        }
        if (specularChance < 1.0) {
            sum += lobes.diffuse() * (rest / kPi) *
                   weighed(density, (1.0 - specularChance) * cosineDensity(l));
        }
        return sum * (l.z / density);
    };

    glm::dvec3 sum(0.0);
    const EnvironmentLight::Choice sky = lighting_.environment.choose(path.random.pair());
    if (const glm::dvec3 share = reflected(sky.direction, sky.density); greatest(share) > 0.0) {
        sum += share * lighting_.environment.along(sky.direction) *
               arriving(World::leaving(point, sky.direction), false);
    }
    if (emitters_.empty()) return sum;
    const double which = path.random.one();
    const Emitters::Choice lamp = emitters_.choose(which, path.random.pair());
    const glm::dvec3 way = lamp.place - point.place;
    const double distance = glm::length(way);
    const glm::dvec3 towards = unitOr(way, point.face);
    const glm::dvec3 share =
        reflected(towards, emitters_.density(lamp.triangle, towards, distance));
    if (!(greatest(share) > 0.0)) return sum;
    const World::Triangle& t = world_.triangles()[lamp.triangle];
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
    if (!world_.meets(lamp.triangle, lamp.weightB, lamp.weightC, glm::dot(normal, towards) < 0.0)) {
        return sum;
    }
    const Point there =
        world_.pointAt({distance, lamp.weightB, lamp.weightC, lamp.triangle}, towards);
    Ray ray = World::leaving(point, towards);
    ray.farthest = distance * (1.0 - 1e-5) - 1e-6 * there.reach;
    return sum + share * there.emitted * arriving(ray, false);
}

}  // namespace clerestory::reference
