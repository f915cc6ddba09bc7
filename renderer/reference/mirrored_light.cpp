// Light of punctual lights by way of flat mirrors, from their images.
#include "reference/bsdf.h"
#include "reference/path.h"

#include <algorithm>

namespace clerestory::reference {

bool PathTracer::wasSampled(const Path& path, const SurfaceInteraction& mirror) const {
    const auto& all = geometry_.flatMirrors();
    return path.mirrorsSampled && std::any_of(all.begin(), all.end(), [&](const FlatMirror& m) {
               return &geometry_.surfaceOf(m) == mirror.surface;
           });
}

glm::dvec3 PathTracer::evalMirroredLights(Path& path, const SurfaceInteraction& point,
                                          const Bsdf& bsdf) const {
    // Images are sampled in proportion to their light if nothing hid it (weighted reservoir
    // sampling).
    struct Chosen {
        const FlatMirror* mirror = nullptr;
        LightSample light;
        double weight = 0.0;
    } chosen;
    double total = 0.0, u = -1.0;
    for (const PunctualLight& source : lighting_.lights) {
        for (const FlatMirror& mirror : geometry_.flatMirrors()) {
            if (!mirror.shows(source, point.position)) continue;
            const PunctualLight image = mirror.imageOf(source);
            LightSample light = evalLight(image, point.position);
            const double weight =
                luminance(light.irradiance) * std::max(glm::dot(point.normal, light.toLight), 0.0);
            if (!(weight > 0.0)) continue;
            if (u < 0.0) u = path.sampler.get1D();
            total += weight;
            const double probability = weight / total;
            if (u < probability) {
                if (source.radius > 0.0) light = towardsDisc(image, light, path.sampler.get2D());
                chosen = {&mirror, light, weight};
                u /= probability;
            } else {
                u = (u - probability) / (1.0 - probability);
            }
        }
    }
    const glm::dvec3& towards = chosen.light.toLight;
    if (!chosen.mirror || glm::dot(towards, point.geometricNormal) <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 local = bsdf.frame().toLocal(towards);
    const glm::dvec3 lobes =
        bsdf.isWide() ? bsdf.evalPunctual(local, 1.0) : bsdf.evalDiffuse(local);
    const glm::dvec3 reflected = lobes * std::max(glm::dot(point.normal, towards), 0.0);
    if (!(greatest(reflected) > 0.0)) return glm::dvec3(0.0);
    const Passage toMirror = passage(SceneGeometry::spawnRay(point, towards), ThroughGlass::none,
                                     &geometry_.surfaceOf(*chosen.mirror));
    if (!toMirror.end) return glm::dvec3(0.0);
    const SurfaceInteraction& at = *toMirror.end;
    const double cosine = std::abs(glm::dot(chosen.mirror->plane.normal, towards));
    Ray onwards = SceneGeometry::spawnRay(at, chosen.mirror->turned(towards));
    onwards.tMax =
        (chosen.light.distance - glm::distance(point.position, at.position)) * (1.0 - 1e-6);
    return reflected * chosen.light.irradiance * (total / chosen.weight) * toMirror.transmittance *
           Bsdf(at, -towards).fresnel(cosine) * transmittance(onwards, ThroughGlass::all);
}

}  // namespace clerestory::reference
