// Direct light: punctual lights, and, in mode `full`, emissive triangles and the environment,
// sampled and weighted against BSDF sampling.
#include "reference/bsdf.h"
#include "reference/path.h"

namespace clerestory::reference {
namespace {

constexpr int kMaxTransparentSurfaces = 64;  // along a shadow ray

}  // namespace

PathTracer::Passage PathTracer::passage(Ray ray, ThroughGlass glass, const Surface* end) const {
    if (!end && !geometry_.hasTransparency()) {
        return {glm::dvec3(geometry_.occluded(ray) ? 0.0 : 1.0), {}};
    }
    glm::dvec3 result(1.0);
    MediumStack media;
    for (int i = 0; i < kMaxTransparentSurfaces; ++i) {
        const std::optional<Hit> hit = geometry_.intersect(ray);
        if (!hit) return {result, {}};
        const SurfaceInteraction p = geometry_.interactionAt(*hit, ray.direction);
        if (media.count > 0) {
            const Material& m = *media.top().material;
            result *= beerLambert(m.attenuationColor, m.attenuationDistance, hit->distance);
        }
        if (end && p.surface == end) return {result, p};
        glm::dvec3 atSurface(1.0 - p.coverage);
        const bool passes =
            glass == ThroughGlass::all || (glass == ThroughGlass::clear && !scattersLight(p));
        if (passes && p.transmission > 0.0) {
            const double cosine = -glm::dot(p.normal, ray.direction);
            const double ior = std::max(1.0, double(p.material->ior));
            glm::dvec3 throughSurface;
            if (p.surface->glass == Glass::pane) {
                const double insideCosine = std::max(refractedCosine(cosine, ior), 1e-3);
                const Material& m = *p.material;
                throughSurface =
                    p.baseColor *
                    paneCoefficients(cosine, ior,
                                     beerLambert(m.attenuationColor, m.attenuationDistance,
                                                 p.thickness / insideCosine))
                        .transmitted;
            } else {
                // Not refracted: light leaves the body at the angle of incidence.
                throughSurface = glm::dvec3(1.0 - fresnel(cosine, ior).mean());
                if (p.front) {
                    throughSurface *= p.baseColor;
                    media.enter(p);
                } else {
                    media.leave(p);
                }
            }
            atSurface += p.coverage * p.transmission * (1.0 - p.metallic) * throughSurface;
        }
        result *= atSurface;
        if (!(greatest(result) > 0.0)) return {};
        Ray next = SceneGeometry::spawnRay(p, ray.direction);
        next.tMax = ray.tMax - hit->distance;
        ray = next;
    }
    return {};
}

// normal: of the face, on the side of the lights. scattered: factor on the irradiance of a surface
// that faces the light, by the direction towards it.
template <class Scattered>
glm::dvec3 PathTracer::sampleLights(Path& path, const SurfaceInteraction& point,
                                    const glm::dvec3& normal, ThroughGlass glass,
                                    Scattered scattered) const {
    glm::dvec3 sum(0.0);
    // Mode `full` samples one light in proportion to its unshadowed contribution (weighted
    // reservoir sampling).
    struct Chosen {
        const PunctualLight* source = nullptr;
        LightSample light;
        glm::dvec3 scattered{0.0};
        double luminance = 0.0;
    } chosen;
    double total = 0.0;
    double u = mode_ == ReferenceMode::full && !lighting_.lights.empty() ? path.sampler.get1D() : 0;
    for (const PunctualLight& source : lighting_.lights) {
        const LightSample light = evalLight(source, point.position);
        if (!(greatest(light.irradiance) > 0.0)) continue;
        const glm::dvec3 contribution = light.irradiance * scattered(light.toLight);
        sum += contribution;
        const double weight = luminance(contribution);
        if (mode_ == ReferenceMode::effects || !(weight > 0.0)) continue;
        total += weight;
        // One random number serves all choices: after each choice it is rescaled to [0, 1).
        const double probability = weight / total;
        if (u < probability) {
            chosen = {&source, light, contribution, weight};
            u /= probability;
        } else {
            u = (u - probability) / (1.0 - probability);
        }
    }
    if (mode_ == ReferenceMode::effects) return sum;
    if (chosen.source && chosen.source->radius > 0.0) {
        chosen.light = towardsDisc(*chosen.source, chosen.light, path.sampler.get2D());
        chosen.scattered = chosen.light.irradiance * scattered(chosen.light.toLight);
    }
    if (!(chosen.luminance > 0.0) || glm::dot(chosen.light.toLight, normal) <= 0.0) {
        return glm::dvec3(0.0);
    }
    Ray ray = SceneGeometry::spawnRay(point, chosen.light.toLight);
    ray.tMax = chosen.light.distance * (1.0 - 1e-6);
    return chosen.scattered * (total / chosen.luminance) * transmittance(ray, glass);
}

glm::dvec3 PathTracer::evalPunctualLights(Path& path, const SurfaceInteraction& point,
                                          const Bsdf& bsdf, double diffuseScale) const {
    return sampleLights(path, point, point.geometricNormal, ThroughGlass::all,
                        [&](const glm::dvec3& towards) {
                            const double cosine = glm::dot(point.normal, towards);
                            if (!(cosine > 0.0)) return glm::dvec3(0.0);
                            return cosine * bsdf.evalPunctual(bsdf.frame().toLocal(towards),
                                                              diffuseScale, point.discRadius2);
                        });
}

glm::dvec3 PathTracer::evalLightsBehind(Path& path, const SurfaceInteraction& point,
                                        const Frame& frame, const glm::dvec3& v, double alpha,
                                        double eta, bool reflects) const {
    return sampleLights(
        path, point, -point.geometricNormal, ThroughGlass::clear, [&](const glm::dvec3& towards) {
            const glm::dvec3 l = frame.toLocal(towards);
            const double pdf = refractionPdf(v, l, alpha, eta);
            if (!reflects || !(pdf > 0.0)) return glm::dvec3(pdf);
            return glm::dvec3(
                pdf * (1.0 - fresnel(glm::dot(v, refractingNormal(v, l, eta)), eta).mean()));
        });
}

glm::dvec3 PathTracer::evalAreaLights(Path& path, const SurfaceInteraction& point, const Bsdf& bsdf,
                                      const LobeChoice& choice) const {
    // Estimator weight of light from `towards`, sampled with density `pdf`.
    const auto reflected = [&](const glm::dvec3& towards, double pdf) {
        const glm::dvec3 l = bsdf.frame().toLocal(towards);
        if (l.z <= 0.0 || glm::dot(towards, point.geometricNormal) <= 0.0 || !(pdf > 0.0)) {
            return glm::dvec3(0.0);
        }
        glm::dvec3 sum(0.0);
        const double specularPdf = choice.specular ? bsdf.specularPdf(l) : 0.0;
        if (specularPdf > 0.0) {
            const glm::dvec3 lobe = bsdf.evalSpecular(l);
            const double probability = choice.probability(lobe * (l.z / specularPdf));
            sum += lobe * balanceHeuristic(pdf, probability * specularPdf);
        }
        if (choice.diffuseProbability > 0.0) {
            sum += choice.diffuse / kPi *
                   balanceHeuristic(pdf, choice.diffuseProbability * cosineHemispherePdf(l));
        }
        return sum * (l.z / pdf);
    };

    glm::dvec3 sum(0.0);
    const EnvironmentLight::Sample sky = lighting_.environment.sample(path.sampler.get2D());
    if (const glm::dvec3 weight = reflected(sky.direction, sky.pdf); greatest(weight) > 0.0) {
        sum += weight * lighting_.environment.radiance(sky.direction) *
               transmittance(SceneGeometry::spawnRay(point, sky.direction), ThroughGlass::none);
    }
    if (emitters_.empty()) return sum;
    const double uTriangle = path.sampler.get1D();
    const Emitters::Sample emitter = emitters_.sample(uTriangle, path.sampler.get2D());
    const glm::dvec3 offset = emitter.position - point.position;
    const double distance = glm::length(offset);
    const glm::dvec3 towards = unitOr(offset, point.geometricNormal);
    const glm::dvec3 weight =
        reflected(towards, emitters_.pdf(emitter.triangle, towards, distance));
    if (!(greatest(weight) > 0.0)) return sum;
    const SceneGeometry::Triangle& t = geometry_.triangles()[emitter.triangle];
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a));
    if (!geometry_.acceptsHit(emitter.triangle, emitter.weightB, emitter.weightC,
                              glm::dot(normal, towards) < 0.0)) {
        return sum;
    }
    const SurfaceInteraction there = geometry_.interactionAt(
        {distance, emitter.weightB, emitter.weightC, emitter.triangle}, towards);
    return sum + weight * there.emission *
                     transmittance(SceneGeometry::spawnRayTo(point, there), ThroughGlass::none);
}

}  // namespace clerestory::reference
