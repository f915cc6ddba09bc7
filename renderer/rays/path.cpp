#include "rays/path.h"

#include "rays/lobes.h"
#include "rays/straight_rays.h"

#include <algorithm>
#include <cmath>

namespace clerestory::rays {
namespace {

using shader::vec3;

const float* floatsOf(std::span<const glm::vec4> rows) {
    return rows.empty() ? nullptr : &rows.front().x;
}

shader::Scene sceneOf(const Surroundings& s) {
    shader::Scene scene{};
    for (int row = 0; row < 3; ++row) {
        scene.viewBlock.worldFromEye[row] = {s.worldFromEye[0][row], s.worldFromEye[1][row],
                                             s.worldFromEye[2][row], 0.0f};
    }
    scene.viewBlock.environment = {static_cast<float>(s.environment.levels()) - 1.0f,
                                   s.environmentIntensity, 0.0f, 0.0f};
    scene.tracingBlock.eye = {s.eye.x, s.eye.y, s.eye.z, 0.0f};
    scene.tracingBlock.limits = {static_cast<float>(s.bounces),
                                 static_cast<float>(s.firstTextureRow), s.leastShare, 0.0f};
    if (s.background) {
        scene.tracingBlock.background = {s.background->x, s.background->y, s.background->z, 1.0f};
    }
    scene.features = static_cast<std::uint32_t>(s.hitFeatures);
    scene.layers = static_cast<std::uint32_t>(s.hitFeatures >> 32);
    scene.viewBits =
        (s.surfaceLight.empty() ? 0u : shader::VIEW_SURFACE_LIGHT) |
        (s.shadows ? shader::VIEW_SHADOWS : 0u) |
        (s.shadowSamples > 0 ? shader::VIEW_SHADOWS_SOFT : 0u) |
        (s.shadowMap && !s.shadowMap->tints.empty() ? shader::VIEW_SHADOWS_TINTED : 0u);
    scene.surfaceLight = {s.surfaceLight.data()};
    scene.triangles = {&s.tree};
    scene.vertices = {s.vertices.empty() ? nullptr : &s.vertices.front().position.x};
    scene.indices = {s.indices.data()};
    scene.instances = {floatsOf(s.instances)};
    scene.materials = {floatsOf(s.materials)};
    scene.lights = {floatsOf(s.lights)};
    scene.texels = {s.texels.data()};
    scene.brdf = {s.brdf.empty() ? nullptr : &s.brdf.front().x, static_cast<int>(s.brdfSize)};
    scene.environment = {&s.environment};
    scene.shadowMap = {s.shadowMap};
    scene.shadowDepths = {s.shadowMap};
    scene.shadowTints = {s.shadowMap};
    if (s.shadowMap) {
        scene.viewBlock.shadows = {1.0f / static_cast<float>(s.shadowMap->width),
                                   1.0f / static_cast<float>(s.shadowMap->height),
                                   static_cast<float>(s.shadowSamples), 0.0f};
    }
    return scene;
}

}  // namespace

// Mirrors of less roughness than 0.1, and glass that blurs as little.
constexpr float kLeastLobe = 0.02f;

RecordedRay rayOf(const Start& start, const Way& way) {
    const shader::vec2 cone = shader::halves(start.cone);
    const shader::vec2 redGreen = shader::halves(way.shareRedGreen),
                       blueLobe = shader::halves(way.shareBlueLobe);
    const vec3 along = shader::directionOf(way);
    return {.start = {start.place[0], start.place[1], start.place[2]},
            .along = {along.x, along.y, along.z},
            .share = {redGreen.x, redGreen.y, blueLobe.x},
            .width = shader::exp2(cone.y),
            .pixel = cone.x,
            .lobe = shader::abs(blueLobe.y),
            .intoBody = std::signbit(blueLobe.y)};  // -0: a smooth face
}

bool isRough(const RecordedRay& ray) {
    return ray.lobe >= kLeastLobe;
}

struct PathTracer::Scene : shader::Scene {
    vec3 backwards{0.0f};

    vec3 toEyeFrom(vec3 start) const {
        const bool perspective = shader::dot(backwards, backwards) == 0.0f;
        const vec3 eye(tracingBlock.eye.x, tracingBlock.eye.y, tracingBlock.eye.z);
        return shader::eyeAxesOf(perspective ? eye - start : backwards);
    }
};

namespace {

vec3 vectorOf(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}

// The lobe as one direction with a width.
shader::RoundLobe roundLobeOf(const RecordedRay& ray, Ray kind, vec3 toEye) {
    const vec3 along = vectorOf(ray.along);
    if (kind == Ray::mirrored) return shader::mirroredLobe(along, toEye, ray.lobe);
    return {along, 0.5f * ray.lobe};
}

shader::RayCone coneOf(const RecordedRay& ray, const shader::RoundLobe& round) {
    return {ray.width, ray.pixel, 2.0f * round.alpha};
}

const std::uint32_t kNothingMet = shader::hashOfSurfaces(shader::kNoSurfaces, -1) | 1u;

}  // namespace

bool Path::open() const {
    return surfaces == kNothingMet;
}

PathTracer::PathTracer(const Surroundings& surroundings)
    : scene_(new Scene{sceneOf(surroundings)}) {
    const glm::vec3 b = surroundings.towardsEye;
    scene_->backwards = {b.x, b.y, b.z};
}
PathTracer::~PathTracer() = default;

Path PathTracer::follow(const RecordedRay& ray, Ray kind, const Lobe& lobe) const {
    shader::scene = scene_.get();
    shader::scatter = {};
    const vec3 along = vectorOf(ray.along);
    shader::Sum sum;
    const bool direct = kind == Ray::transmitted;
    const vec3 toEye = scene_->toEyeFrom(vectorOf(ray.start));
    if (lobe.paths > 1 && isRough(ray)) {
        for (std::uint32_t i = 0; i < lobe.paths; ++i) {
            shader::scatter = {
                lobe.paths, i, lobe.pattern, 0,
                1.0f / std::sqrt(shader::kPathsOfNeighbours * static_cast<float>(lobe.paths))};
            const shader::LobeRay next =
                kind == Ray::mirrored ? shader::mirroredInLobe(along, toEye, ray.lobe)
                                      : shader::transmittedInLobe(along, ray.lobe, ray.intoBody);
            if (next.weight <= 0.0f) continue;
            shader::addPath(sum, ray, direct, next.along, toEye, {ray.width, ray.pixel, next.lobe},
                            next.weight);
        }
    }
    const shader::RoundLobe round = roundLobeOf(ray, kind, toEye);
    const shader::RayCone cone = coneOf(ray, round);
    if (!(sum.weight + sum.openWeight > 1e-3f)) {
        shader::scatter = {};
        sum = {};
        shader::addPath(sum, ray, direct, round.along, toEye, cone, 1.0f);
    } else if (sum.openWeight > 0.0f) {
        // The weight of the prefiltered map grows with the open fraction of the lobe.
        const vec3 whole =
            shader::radianceFinite(shader::backgroundAtEnd(round.along, cone, direct));
        sum.open = shader::mix(sum.open, whole * sum.openWeight,
                               sum.openWeight / (sum.weight + sum.openWeight));
    }
    const float weight = sum.weight + sum.openWeight;
    const vec3 mean = (sum.radiance + sum.open) / weight;
    return {{mean.x, mean.y, mean.z}, sum.surfaces | 1u, weight / sum.nearness, sum.paths};
}

Path PathTracer::open(const RecordedRay& ray, Ray kind) const {
    shader::scene = scene_.get();
    const shader::RoundLobe round = roundLobeOf(ray, kind, scene_->toEyeFrom(vectorOf(ray.start)));
    const vec3 radiance = shader::radianceFinite(
        shader::backgroundAtEnd(round.along, coneOf(ray, round), kind == Ray::transmitted));
    return {{radiance.x, radiance.y, radiance.z}, kNothingMet, shader::kFarAway, 0};
}

SurfaceHit PathTracer::surfaceAlong(const glm::vec3& start, const glm::vec3& along, float width,
                                    float spread, float limit, const TriangleHit* first) const {
    shader::scene = scene_.get();
    const vec3 from = vectorOf(start), way = vectorOf(along);
    return shader::surfaceAlong(
        from, way, {width, spread, 0.0f}, limit,
        first ? shader::hitOf(*first) : shader::nearest(from, shader::worldAxes(way)));
}

std::optional<PointHit> PathTracer::pointAlong(const glm::vec3& start, const glm::vec3& along,
                                               float width, float spread) const {
    shader::scene = scene_.get();
    return shader::pointAlong({start.x, start.y, start.z}, {along.x, along.y, along.z},
                              {width, spread, 0.0f});
}

std::optional<SurfaceHit> PathTracer::middleOf(std::uint32_t place) const {
    shader::scene = scene_.get();
    return shader::middleOf(place);
}

}  // namespace clerestory::rays
