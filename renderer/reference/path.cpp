// The walk, and opaque points.
#include "reference/path.h"

#include "reference/fresnel.h"

namespace clerestory::reference {
namespace {

// The end of a path that cannot lose light, which chance reaches once in e^50.
constexpr int kMaxTurns = 1200;

// Rougher lobes are found by chance, and discs of slopes are no wider.
constexpr double kMaxAveraged = 0.6, kMaxCovered = 0.5;

// The chance that a path of that weight goes on after so many turns. Mirrors in mirrors are
// followed for as long as they are seen clearly; light that diffuse walls have spread is not.
double survivalProbability(ReferenceMode mode, int turns, double bright) {
    constexpr double kMax = 0.95;
    if (mode == ReferenceMode::full) return turns < 3 ? 1.0 : std::min(bright, kMax);
    constexpr double kFaint = 0.1;
    return turns < 8 ? 1.0 : std::min(bright / kFaint, turns < 128 ? 1.0 : kMax);
}

}  // namespace

glm::dvec3 above(const glm::dvec3& direction, const glm::dvec3& face) {
    constexpr double kAlong = 1e-3;
    const double height = glm::dot(direction, face);
    return height >= kAlong ? direction : unitOr(direction + face * (kAlong - height), face);
}

void Media::enter(const Point& point) {
    if (count < kMax) bodies[count++] = {point.instance, point.material};
}

bool Media::leave(const Point& point) {
    for (std::size_t i = count; i-- > 0;) {
        if (bodies[i].instance != point.instance) continue;
        for (std::size_t k = i; k + 1 < count; ++k) bodies[k] = bodies[k + 1];
        --count;
        return true;
    }
    return false;
}

PathTracer::PathTracer(const World& world, const Lighting& lighting, const Effects& effects,
                       ReferenceMode mode)
    : world_(world), lighting_(lighting), effects_(effects), mode_(mode), emitters_(world) {}

void PathTracer::Path::turn(const Ray& next, const glm::dvec3& share, double turnDensity) {
    ray = next;
    weight *= share;
    density = turnDensity;
    travelled = 0.0;
}

glm::dvec3 PathTracer::radiance(const Ray& ray, Random& random, const PixelShare& share) const {
    Path path{.ray = ray, .random = random, .stands = share};
    for (int turns = 0; !path.ended && turns < kMaxTurns; ++turns) {
        if (const std::optional<Hit> hit = world_.nearest(path.ray))
            meet(path, *hit);
        else
            meetNothing(path);
        const double bright = greatest(path.weight);
        if (!(bright > 0.0)) break;
        const double chance = survivalProbability(mode_, turns, bright);
        if (chance >= 1.0) continue;
        if (random.one() >= chance) break;
        path.weight /= chance;
    }
    return path.sum;
}

void PathTracer::meetNothing(Path& path) const {
    path.ended = true;
    if (path.straight && !lighting_.backgroundVisible) return;
    glm::dvec3 light = lighting_.environment.along(path.ray.direction);
    if (path.density > 0.0) {
        const double other = lighting_.environment.density(path.ray.direction);
        light *= path.density / (path.density + other);
    }
    path.sum += path.weight * light;
}

glm::dvec3 PathTracer::emittedAt(const Path& path, const Point& point) const {
    if (!(greatest(point.emitted) > 0.0) || path.density <= 0.0) return point.emitted;
    const double other = emitters_.density(point.triangle, path.ray.direction, path.travelled);
    return point.emitted * (path.density / (path.density + other));
}

void PathTracer::meet(Path& path, const Hit& hit) const {
    path.travelled += hit.distance;
    path.stands.width += path.stands.spread * hit.distance;
    if (path.media.count > 0) {
        const Material& m = *path.media.last().material;
        path.weight *= absorbed(m.attenuationColor, m.attenuationDistance, hit.distance);
    }
    Point point = world_.pointAt(hit, path.ray.direction);
    path.sum += path.weight * emittedAt(path, point);
    if (point.coverage < 1.0 && path.random.one() >= point.coverage) {
        path.ray = World::leaving(point, path.ray.direction);
        return;
    }
    if (point.material->unlit) {
        path.sum += path.weight * point.baseColor;
        path.ended = true;
        return;
    }
    if (path.stands.edge > 0.0 && point.roughness < kMaxAveraged && !lighting_.lamps.empty()) {
        point.turn = world_.turnAcross(hit, point, path.ray.direction, path.stands.width);
        const double radius2 =
            point.turn * point.turn + 0.25 * path.stands.spread * path.stands.spread;
        point.covered = std::min(radius2 / kPi, kMaxCovered);
    }
    // Only the dielectric part lets light through, so what is beside the clear share is more of a
    // metal than the whole, and the clear share is none.
    const double clear = point.transmission * (1.0 - point.metallic);
    const bool opaque = !(clear > 0.0) || path.random.one() >= clear;
    point.metallic = opaque ? point.metallic / std::max(1.0 - clear, 1e-12) : 0.0;
    if (opaque) return meetOpaque(path, point);
    if (point.front || point.surface->glass == Glass::pane) {
        const Lobes lobes(point, -path.ray.direction);
        path.sum += path.weight * underLamps(path, point, lobes, 0.0);
    }
    if (point.surface->glass == Glass::pane)
        meetPane(path, point);
    else
        meetSolid(path, point);
}

void PathTracer::meetOpaque(Path& path, const Point& point) const {
    const Lobes lobes(point, -path.ray.direction);
    path.sum += path.weight * underLamps(path, point, lobes, 1.0);
    if (mode_ == ReferenceMode::effects)
        meetInEffects(path, point, lobes);
    else
        meetInFull(path, point, lobes);
}

bool PathTracer::hasOwnMap(const Point& point) const {
    return effects_.environmentReflection && point.surface->why == ReflectorReason::map &&
           lighting_.named.contains(point.material->environmentMap);
}

bool PathTracer::traces(const Surface& surface) const {
    if (surface.why == ReflectorReason::map) return false;
    if (mode_ == ReferenceMode::full) return true;
    if (surface.reflector == Reflector::flat) return effects_.planarReflection;
    if (surface.reflector == Reflector::curved || surface.why == ReflectorReason::round) {
        return effects_.environmentReflection;
    }
    return false;
}

glm::dvec3 PathTracer::surroundings(const Point& point, const glm::dvec3& towards) const {
    if (!hasOwnMap(point)) return lighting_.environment.along(towards);
    const glm::dmat3 mapFromWorld =
        glm::transpose(glm::mat3_cast(glm::normalize(point.material->environmentRotation)));
    return lighting_.named.at(point.material->environmentMap).along(mapFromWorld * towards);
}

void PathTracer::meetInEffects(Path& path, const Point& point, const Lobes& lobes) const {
    const Lobes::Facet facet = lobes.facet(path.random.pair());
    path.weight *= point.occlusion;
    path.sum +=
        path.weight * lobes.diffuse() * facet.rest * lighting_.environment.diffuse(point.normal);
    const glm::dvec3 towards = lobes.frame().toWorld(facet.towards);
    if (traces(*point.surface)) {
        path.turn(World::leaving(point, above(towards, point.face)), facet.weight);
        path.widen(lobes.alpha(), point.turn);
        path.straight = false;
        return;
    }
    path.sum += path.weight * facet.weight * surroundings(point, towards);
    path.ended = true;
}

void PathTracer::meetInFull(Path& path, const Point& point, const Lobes& lobes) const {
    const Lobes::Facet facet = lobes.facet(path.random.pair());
    const double specular = greatest(lobes.fresnel(lobes.toEye().z));
    const double diffuse = greatest(lobes.diffuse());
    double chance = diffuse > 0.0 ? std::clamp(specular / (specular + diffuse), 0.1, 0.9) : 1.0;
    path.straight = false;
    if (!traces(*point.surface)) {
        const glm::dvec3 towards = lobes.frame().toWorld(facet.towards);
        path.sum += path.weight * facet.weight * surroundings(point, towards);
        chance = 0.0;
    }
    path.sum += path.weight * underChosenLights(path, point, lobes, chance, facet.rest);
    if (path.random.one() < chance) {
        const glm::dvec3 towards = above(lobes.frame().toWorld(facet.towards), point.face);
        path.turn(World::leaving(point, towards), facet.weight / chance,
                  chance * lobes.densityOf(facet.towards));
        path.widen(lobes.alpha(), point.turn);
        return;
    }
    const glm::dvec3 l = cosineWeighted(path.random.pair());
    const glm::dvec3 towards = lobes.frame().toWorld(l);
    if (glm::dot(towards, point.face) <= 0.0) {
        path.ended = true;  // a bumpy normal's horizon lies behind the face
        return;
    }
    path.turn(World::leaving(point, towards), lobes.diffuse() * (facet.rest / (1.0 - chance)),
              (1.0 - chance) * std::max(cosineDensity(l), 1e-9));
    path.stands = {};
}

}  // namespace clerestory::reference
