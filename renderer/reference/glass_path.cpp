// Scattering at glass, smooth or rough: both sides of a solid's surface, and panes with all
// internal reflections. Where a sampled direction would hit another microfacet, a new microfacet is
// sampled, so that no energy is lost.
#include "reference/bsdf.h"
#include "reference/layers.h"
#include "reference/path.h"

namespace clerestory::reference {
namespace {

constexpr int kMaxAttempts = 8;
const glm::dvec3 kUp(0.0, 0.0, 1.0);

// A visible microfacet normal; the surface normal for smooth glass and for the last attempt.
glm::dvec3 sampleMicrofacet(const glm::dvec3& v, double alpha, int attempt, Sampler& sampler) {
    if (alpha < kMinReferenceAlpha || attempt == kMaxAttempts) return kUp;
    return sampleVisibleNormal(v, alpha, sampler.get2D());
}

}  // namespace

bool scattersLight(const SurfaceInteraction& point) {
    constexpr double kMinRefraction = 1e-3;
    return point.roughness * point.roughness >= kMinPunctualAlpha &&
           point.material->ior >= 1.0 + kMinRefraction;
}

void PathTracer::reflectFromGlass(Path& path, const SurfaceInteraction& point,
                                  const glm::dvec3& towards) const {
    path.fromCamera = false;
    if (point.front && !tracesReflection(point)) {
        path.radiance += path.throughput * environmentRadiance(point, towards);
        path.terminated = true;
        return;
    }
    path.scatter(SceneGeometry::spawnRay(point, clampToHorizon(towards, point.geometricNormal)),
                 glm::dvec3(1.0));
    path.widen(point.roughness * point.roughness, point.normalSpread);
}

// KHR_materials_dispersion. The path keeps one primary, chosen at random.
double PathTracer::dispersedIor(Path& path, const SurfaceInteraction& point) const {
    const double ior = std::max(1.0, point.ior);
    const double dispersion = effects_.materialLayers ? point.material->dispersion : 0.0;
    if (!(dispersion > 0.0)) return ior;
    if (path.primary < 0) {
        path.primary = std::min(int(3.0 * path.sampler.get1D()), 2);
        for (int i = 0; i < 3; ++i) path.throughput[i] *= i == path.primary ? 3.0 : 0.0;
    }
    return std::max(1.0, ior + (path.primary - 1) * (ior - 1.0) * 0.025 * dispersion);
}

void PathTracer::scatterAtSolid(Path& path, const SurfaceInteraction& point) const {
    const Material& m = *point.material;
    const double ior = dispersedIor(path, point);
    MediumStack beyond = path.media;
    if (point.front) {
        beyond.enter(point);
    } else if (!beyond.leave(point)) {
        // The camera is inside the body.
        path.throughput *= beerLambert(m.attenuationColor, m.attenuationDistance, path.distance);
    }
    const double eta = point.front ? ior / path.media.ior() : beyond.ior() / ior;
    const Frame frame(point.normal);
    const glm::dvec3 v = frame.toLocal(-path.ray.direction);
    const double alpha = point.roughness * point.roughness;
    for (int attempt = 0;; ++attempt) {
        const glm::dvec3 facet = sampleMicrofacet(v, alpha, attempt, path.sampler);
        const double cosine = glm::dot(v, facet);
        if (!point.front && scattersLight(point) && !path.glassSampled && attempt < kMaxAttempts) {
            path.radiance +=
                path.throughput * evalLightsBehind(path, point, frame, v, alpha, eta, true);
        }
        const double u = path.sampler.get1D();
        const double bare = fresnel(cosine, eta).mean();
        const glm::dvec3 reflected =
            point.front ? underFilm(point, cosine, bare) : glm::dvec3(bare);
        const double probability = (reflected.x + reflected.y + reflected.z) / 3.0;
        if (u < probability) {
            const glm::dvec3 l = 2.0 * cosine * facet - v;
            if (l.z <= 0.0 && attempt < kMaxAttempts) continue;
            path.throughput *= reflected / probability;
            return reflectFromGlass(path, point, frame.toWorld(l));
        }
        const glm::dvec3 l = refracted(-v, facet, eta);
        if (l.z >= 0.0 && attempt < kMaxAttempts) continue;
        const glm::dvec3 tint = (point.front ? point.baseColor : glm::dvec3(1.0)) *
                                (1.0 - reflected) / (1.0 - probability);
        path.scatter(SceneGeometry::spawnRay(
                         point, clampToHorizon(frame.toWorld(l), -point.geometricNormal)),
                     tint);
        path.media = beyond;
        path.widen(0.5 * alpha, 0.5 * std::abs(eta - 1.0) * point.normalSpread);
        return;
    }
}

void PathTracer::scatterAtPane(Path& path, const SurfaceInteraction& point) const {
    const Material& m = *point.material;
    const double ior = std::max(1.0, double(m.ior));
    const Frame frame(point.normal);
    const glm::dvec3 v = frame.toLocal(-path.ray.direction);
    const double alpha = point.roughness * point.roughness;
    const bool rough = alpha >= kMinReferenceAlpha;
    for (int attempt = 0;; ++attempt) {
        const glm::dvec3 facet = sampleMicrofacet(v, alpha, attempt, path.sampler);
        const double cosine = std::clamp(glm::dot(v, facet), 0.0, 1.0);
        const double insideCosine = std::max(refractedCosine(cosine, ior), 1e-6);
        PaneCoefficients pane = paneCoefficients(
            cosine, ior,
            beerLambert(m.attenuationColor, m.attenuationDistance, point.thickness / insideCosine));
        if (point.layers.film > 0.0) {
            const glm::dvec3 bare(std::min(fresnel(cosine, ior).mean(), 0.999));
            const glm::dvec3 filmed = underFilm(point, cosine, bare.x);
            pane.reflected = glm::clamp(pane.reflected + filmed - bare, 0.0, 1.0);
            pane.transmitted *= (1.0 - filmed) / (1.0 - bare);
        }
        pane.transmitted *= point.baseColor;
        const double reflected = greatest(pane.reflected),
                     total = reflected + greatest(pane.transmitted);
        if (!(total > 0.0)) {
            path.terminated = true;
            return;
        }
        const glm::dvec3 inside = refracted(-v, facet, ior);
        if (scattersLight(point) && !path.glassSampled && inside.z < 0.0 &&
            attempt < kMaxAttempts) {
            path.radiance += path.throughput * pane.transmitted *
                             evalLightsBehind(path, point, frame, -inside, alpha, 1.0 / ior, false);
        }
        const double probability = reflected / total;
        if (path.sampler.get1D() < probability) {
            const glm::dvec3 l = 2.0 * cosine * facet - v;
            if (l.z <= 0.0 && attempt < kMaxAttempts) continue;
            path.throughput *= pane.reflected / probability;
            return reflectFromGlass(path, point, frame.toWorld(l));
        }
        glm::dvec3 exit = -v;
        if (rough && attempt < kMaxAttempts) {
            if (inside.z >= 0.0) continue;
            const glm::dvec3 back = sampleVisibleNormal(-inside, alpha, path.sampler.get2D());
            const double c = -glm::dot(inside, back);
            if (!(c > 0.0) || refractedCosine(c, 1.0 / ior) < 0.0) continue;
            exit = refracted(inside, back, 1.0 / ior);
            if (exit.z >= 0.0) continue;
        }
        const glm::dvec3 direction = rough ? frame.toWorld(exit) : path.ray.direction;
        path.scatter(
            SceneGeometry::spawnRay(point, clampToHorizon(direction, -point.geometricNormal)),
            pane.transmitted / (1.0 - probability));
        path.widen(0.5 * alpha, 0.0);
        // The lateral offset between the refracted path through the pane and the straight one
        // (erratum G3).
        const glm::dvec3 refractedPath = refracted(-v, kUp, ior);
        const double minCosine = 1e-3;
        const double thickness = point.thickness;
        const glm::dvec3 offset =
            refractedPath * (thickness / std::max(-refractedPath.z, minCosine)) +
            v * (thickness / std::max(v.z, minCosine));
        path.ray.origin += frame.toWorld(offset);
        return;
    }
}

}  // namespace clerestory::reference
