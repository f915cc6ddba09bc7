// The main loop, and scattering at opaque surfaces.
#include "reference/path.h"

#include "reference/bsdf.h"
#include "reference/layer_choice.h"

namespace clerestory::reference {
namespace {

// Bounds paths that lose no energy; Russian roulette reaches it with probability e^-50.
constexpr int kMaxBounces = 1200;

// Highlights of rougher lobes are not averaged over the footprint.
constexpr double kMaxAveragedRoughness = 0.6;
constexpr double kMaxDiscRadius2 = 0.5;
// Diameter of the cone of a diffuse bounce, radians: its solid angle is that of the cosine, pi.
// Few samples would blur the light of mirrors too far.
constexpr double kDiffuseSpread = 2.0, kMaxDiffuseSpread = 0.3;

// Russian roulette: the probability that a path of this throughput continues. In mode `effects`,
// where all bounces are specular, only dim paths are terminated early.
double survivalProbability(ReferenceMode mode, int bounces, double throughput) {
    constexpr double kMax = 0.95;
    if (mode == ReferenceMode::full) return bounces < 3 ? 1.0 : std::min(throughput, kMax);
    constexpr double kDim = 0.1;
    return bounces < 8 ? 1.0 : std::min(throughput / kDim, bounces < 128 ? 1.0 : kMax);
}

}  // namespace

glm::dvec3 clampToHorizon(const glm::dvec3& direction, const glm::dvec3& geometricNormal) {
    constexpr double kMinHeight = 1e-3;
    const double height = glm::dot(direction, geometricNormal);
    return height >= kMinHeight
               ? direction
               : unitOr(direction + geometricNormal * (kMinHeight - height), geometricNormal);
}

void MediumStack::enter(const SurfaceInteraction& point) {
    if (count < kMax) bodies[count++] = {point.instance, point.material};
}

bool MediumStack::leave(const SurfaceInteraction& point) {
    for (std::size_t i = count; i-- > 0;) {
        if (bodies[i].instance != point.instance) continue;
        for (std::size_t k = i; k + 1 < count; ++k) bodies[k] = bodies[k + 1];
        --count;
        return true;
    }
    return false;
}

PathTracer::PathTracer(const SceneGeometry& geometry, const Lighting& lighting,
                       const Effects& effects, ReferenceMode mode)
    : geometry_(geometry),
      lighting_(lighting),
      effects_(effects),
      mode_(mode),
      emitters_(geometry) {}

void PathTracer::Path::scatter(const Ray& next, const glm::dvec3& factor, double pdfOfDirection) {
    ray = next;
    throughput *= factor;
    pdf = pdfOfDirection;
    distance = 0.0;
    mirrorsSampled = false;
}

glm::dvec3 PathTracer::radiance(const Ray& ray, Sampler& sampler,
                                const PixelFootprint& footprint) const {
    Path path{.ray = ray, .sampler = sampler, .footprint = footprint};
    for (int bounces = 0; !path.terminated && bounces < kMaxBounces; ++bounces) {
        if (const std::optional<Hit> hit = geometry_.intersect(path.ray))
            scatterAt(path, *hit);
        else
            addBackground(path);
        const double throughput = greatest(path.throughput);
        if (!(throughput > 0.0)) break;
        const double probability = survivalProbability(mode_, bounces, throughput);
        if (probability >= 1.0) continue;
        if (sampler.get1D() >= probability) break;
        path.throughput /= probability;
    }
    return path.radiance;
}

void PathTracer::addBackground(Path& path) const {
    path.terminated = true;
    if (path.fromCamera && !lighting_.backgroundVisible) return;
    glm::dvec3 light = lighting_.environment.radiance(path.ray.direction);
    if (path.pdf > 0.0) {
        light *= balanceHeuristic(path.pdf, lighting_.environment.pdf(path.ray.direction));
    }
    path.radiance += path.throughput * light;
}

glm::dvec3 PathTracer::weightedEmission(const Path& path, const SurfaceInteraction& point) const {
    if (!(greatest(point.emission) > 0.0) || path.pdf <= 0.0) return point.emission;
    const double lightPdf = emitters_.pdf(point.triangle, path.ray.direction, path.distance);
    return point.emission * balanceHeuristic(path.pdf, lightPdf);
}

void PathTracer::scatterAt(Path& path, const Hit& hit) const {
    path.distance += hit.distance;
    path.footprint.width += path.footprint.spread * hit.distance;
    if (path.media.count > 0) {
        const Material& m = *path.media.top().material;
        path.throughput *= beerLambert(m.attenuationColor, m.attenuationDistance, hit.distance);
    }
    SurfaceInteraction point = geometry_.interactionAt(hit, path.ray.direction);
    glm::dvec3 emission = weightedEmission(path, point);
    if (point.layers.clearcoat > 0.0) emission *= belowClearcoat(point, -path.ray.direction);
    path.radiance += path.throughput * emission;
    if (point.coverage < 1.0 && path.sampler.get1D() >= point.coverage) {
        path.ray = SceneGeometry::spawnRay(point, path.ray.direction);
        return;
    }
    if (point.material->unlit) {
        path.radiance += path.throughput * point.baseColor;
        path.terminated = true;
        return;
    }
    if (path.footprint.fraction > 0.0 && point.roughness < kMaxAveragedRoughness &&
        !lighting_.lights.empty()) {
        point.normalSpread =
            geometry_.normalSpreadAcross(hit, point, path.ray.direction, path.footprint.width);
        const double radius2 = point.normalSpread * point.normalSpread +
                               0.25 * path.footprint.spread * path.footprint.spread;
        point.discRadius2 = std::min(radius2 / kPi, kMaxDiscRadius2);
    }
    // Only the dielectric part transmits. So the opaque part is more metallic than the whole, and
    // the transmitting part is not metallic.
    const double transmitting = point.transmission * (1.0 - point.metallic);
    const bool opaque = !(transmitting > 0.0) || path.sampler.get1D() >= transmitting;
    point.metallic = opaque ? point.metallic / std::max(1.0 - transmitting, 1e-12) : 0.0;
    if (opaque) return scatterAtOpaque(path, point);
    if (point.front || point.surface->glass == Glass::pane) {
        const Bsdf bsdf(point, -path.ray.direction);
        path.radiance += path.throughput * evalPunctualLights(path, point, bsdf, 0.0);
    }
    if (point.surface->glass == Glass::pane)
        scatterAtPane(path, point);
    else
        scatterAtSolid(path, point);
}

void PathTracer::scatterAtOpaque(Path& path, SurfaceInteraction point) const {
    chooseLayer(point, -path.ray.direction, path.sampler, path.throughput);
    const Bsdf bsdf(point, -path.ray.direction);
    if (!wasSampled(path, point)) {
        path.radiance += path.throughput * evalPunctualLights(path, point, bsdf, 1.0);
    }
    if (mode_ == ReferenceMode::effects)
        scatterInEffects(path, point, bsdf);
    else
        scatterInFull(path, point, bsdf);
}

bool PathTracer::hasMaterialMap(const SurfaceInteraction& point) const {
    return effects_.environmentReflection && point.surface->reason == ReflectorReason::map &&
           lighting_.named.contains(point.material->environmentMap);
}

bool PathTracer::tracesReflection(const SurfaceInteraction& point) const {
    const Surface& surface = *point.surface;
    if (surface.reason == ReflectorReason::map) return false;
    if (mode_ == ReferenceMode::full) return true;
    using Lobe = SurfaceInteraction::Lobe;
    if (point.lobe == Lobe::sheen || point.lobe == Lobe::transmitted) return false;
    if (surface.reason == ReflectorReason::clearcoat) {
        return effects_.planarReflection && point.lobe == Lobe::clearcoat;
    }
    if (surface.reflector == Reflector::flat) return effects_.planarReflection;
    if (surface.reflector == Reflector::curved ||
        surface.reason == ReflectorReason::curvedDielectric) {
        return effects_.environmentReflection;
    }
    return false;
}

glm::dvec3 PathTracer::environmentRadiance(const SurfaceInteraction& point,
                                           const glm::dvec3& towards) const {
    if (!hasMaterialMap(point)) return lighting_.environment.radiance(towards);
    const glm::dmat3 mapFromWorld =
        glm::transpose(glm::mat3_cast(glm::normalize(point.material->environmentRotation)));
    return lighting_.named.at(point.material->environmentMap).radiance(mapFromWorld * towards);
}

void PathTracer::scatterInEffects(Path& path, const SurfaceInteraction& point,
                                  const Bsdf& bsdf) const {
    const Bsdf::SpecularSample specular = bsdf.sampleSpecular(path.sampler.get2D());
    // An occlusion texture represents what hides the environment; rays see that themselves.
    path.radiance += path.throughput * point.occlusion * bsdf.diffuse() * specular.diffuseFactor *
                     lighting_.environment.irradianceOverPi(point.normal);
    const glm::dvec3 towards = bsdf.frame().toWorld(specular.direction);
    if (tracesReflection(point)) {
        path.scatter(SceneGeometry::spawnRay(point, clampToHorizon(towards, point.geometricNormal)),
                     specular.weight);
        path.widen(bsdf.alpha(), point.normalSpread);
        path.fromCamera = false;
        return;
    }
    path.radiance +=
        path.throughput * point.occlusion * specular.weight * environmentRadiance(point, towards);
    path.terminated = true;
}

void PathTracer::scatterInFull(Path& path, const SurfaceInteraction& point,
                               const Bsdf& bsdf) const {
    const Bsdf::SpecularSample specular = bsdf.sampleSpecular(path.sampler.get2D());
    LobeChoice choice{.diffuse = bsdf.diffuse() * specular.diffuseFactor,
                      .albedo = greatest(bsdf.diffuse()),
                      .specular = tracesReflection(point)};
    path.fromCamera = false;
    if (!choice.specular) {
        const glm::dvec3 towards = bsdf.frame().toWorld(specular.direction);
        path.radiance += path.throughput * specular.weight * environmentRadiance(point, towards);
    }
    const double probability = choice.probability(specular.weight);
    choice.diffuseProbability = 1.0 - probability;
    path.radiance += path.throughput * (evalAreaLights(path, point, bsdf, choice) +
                                        evalMirroredLights(path, point, bsdf));
    if (path.sampler.get1D() < probability) {
        const glm::dvec3 towards =
            clampToHorizon(bsdf.frame().toWorld(specular.direction), point.geometricNormal);
        path.scatter(SceneGeometry::spawnRay(point, towards), specular.weight / probability,
                     probability * bsdf.specularPdf(specular.direction));
        path.widen(bsdf.alpha(), point.normalSpread);
        path.mirrorsSampled = path.glassSampled = bsdf.isWide();
        return;
    }
    const glm::dvec3 l = sampleCosineHemisphere(path.sampler.get2D());
    const glm::dvec3 towards = bsdf.frame().toWorld(l);
    if (glm::dot(towards, point.geometricNormal) <= 0.0) {
        path.terminated =
            true;  // below the surface: the shading normal differs from the geometric one
        return;
    }
    path.scatter(SceneGeometry::spawnRay(point, towards), choice.diffuse / (1.0 - probability),
                 (1.0 - probability) * std::max(cosineHemispherePdf(l), 1e-9));
    path.mirrorsSampled = path.glassSampled = true;
    path.footprint.spread = std::min(kDiffuseSpread * path.footprint.fraction, kMaxDiffuseSpread);
}

}  // namespace clerestory::reference
