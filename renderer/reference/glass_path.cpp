// Glass: both sides of a solid's surface, panes with all their inner bounces, smooth or rough.
// Light that a second facet would catch is not lost: another facet is tried.
#include "reference/fresnel.h"
#include "reference/microfacet.h"
#include "reference/path.h"

namespace clerestory::reference {
namespace {

constexpr int kMaxTries = 8;
const glm::dvec3 kUp(0.0, 0.0, 1.0);

// A facet as v sees them; the last try is the surface itself, as is the first of smooth glass.
glm::dvec3 facetFor(const glm::dvec3& v, double alpha, int attempt, Random& random) {
    if (alpha < kMinReferenceAlpha || attempt == kMaxTries) return kUp;
    return visibleFacet(v, alpha, random.pair());
}

}  // namespace

void PathTracer::reflectGlass(Path& path, const Point& point, const glm::dvec3& towards) const {
    path.straight = false;
    if (point.front && !traces(*point.surface)) {
        path.sum += path.weight * surroundings(point, towards);
        path.ended = true;
        return;
    }
    path.turn(World::leaving(point, above(towards, point.face)), glm::dvec3(1.0));
    path.widen(point.roughness * point.roughness, point.turn);
}

void PathTracer::meetSolid(Path& path, const Point& point) const {
    const Material& m = *point.material;
    const double own = std::max(1.0, double(m.ior));
    Media beyond = path.media;
    if (point.front) {
        beyond.enter(point);
    } else if (!beyond.leave(point)) {
        // The eye is inside.
        path.weight *= absorbed(m.attenuationColor, m.attenuationDistance, path.travelled);
    }
    const double eta = point.front ? own / path.media.index() : beyond.index() / own;
    const Frame frame(point.normal);
    const glm::dvec3 v = frame.toLocal(-path.ray.direction);
    const double alpha = point.roughness * point.roughness;
    for (int attempt = 0;; ++attempt) {
        const glm::dvec3 facet = facetFor(v, alpha, attempt, path.random);
        const double cosine = glm::dot(v, facet);
        const double choice = path.random.one();
        if (choice < fresnel(cosine, eta).mean()) {
            const glm::dvec3 l = 2.0 * cosine * facet - v;
            if (l.z <= 0.0 && attempt < kMaxTries) continue;
            return reflectGlass(path, point, frame.toWorld(l));
        }
        const glm::dvec3 l = refracted(-v, facet, eta);
        if (l.z >= 0.0 && attempt < kMaxTries) continue;
        const glm::dvec3 tint = point.front ? point.baseColor : glm::dvec3(1.0);
        path.turn(World::leaving(point, above(frame.toWorld(l), -point.face)), tint);
        path.media = beyond;
        path.widen(0.5 * alpha, 0.5 * std::abs(eta - 1.0) * point.turn);
        return;
    }
}

void PathTracer::meetPane(Path& path, const Point& point) const {
    const Material& m = *point.material;
    const double ior = std::max(1.0, double(m.ior));
    const Frame frame(point.normal);
    const glm::dvec3 v = frame.toLocal(-path.ray.direction);
    const double alpha = point.roughness * point.roughness;
    const bool rough = alpha >= kMinReferenceAlpha;
    for (int attempt = 0;; ++attempt) {
        const glm::dvec3 facet = facetFor(v, alpha, attempt, path.random);
        const double cosine = std::clamp(glm::dot(v, facet), 0.0, 1.0);
        const double inside = std::max(refractedCosine(cosine, ior), 1e-6);
        PaneShares shares = paneShares(
            cosine, ior,
            absorbed(m.attenuationColor, m.attenuationDistance, point.thickness / inside));
        shares.transmitted *= point.baseColor;
        const double bright = greatest(shares.reflected),
                     all = bright + greatest(shares.transmitted);
        if (!(all > 0.0)) {
            path.ended = true;
            return;
        }
        const double chance = bright / all;
        if (path.random.one() < chance) {
            const glm::dvec3 l = 2.0 * cosine * facet - v;
            if (l.z <= 0.0 && attempt < kMaxTries) continue;
            path.weight *= shares.reflected / chance;
            return reflectGlass(path, point, frame.toWorld(l));
        }
        glm::dvec3 out = -v;
        if (rough && attempt < kMaxTries) {
            const glm::dvec3 within = refracted(-v, facet, ior);
            if (within.z >= 0.0) continue;
            const glm::dvec3 back = visibleFacet(-within, alpha, path.random.pair());
            const double c = -glm::dot(within, back);
            if (!(c > 0.0) || refractedCosine(c, 1.0 / ior) < 0.0) continue;
            out = refracted(within, back, 1.0 / ior);
            if (out.z >= 0.0) continue;
        }
        const glm::dvec3 along = rough ? frame.toWorld(out) : path.ray.direction;
        path.turn(World::leaving(point, above(along, -point.face)),
                  shares.transmitted / (1.0 - chance));
        path.widen(0.5 * alpha, 0.0);
        // Aside, as far as the bent way through the pane lies from the straight one (erratum G3).
        const glm::dvec3 bent = refracted(-v, kUp, ior);
        const double straightest = 1e-3;
        const double thickness = point.thickness;
        const glm::dvec3 aside = bent * (thickness / std::max(-bent.z, straightest)) +
                                 v * (thickness / std::max(v.z, straightest));
        path.ray.origin += frame.toWorld(aside);
        return;
    }
}

}  // namespace clerestory::reference
