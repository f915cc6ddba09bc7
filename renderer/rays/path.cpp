#include "rays/path.h"

#include "rays/first_rays.h"
#include "rays/straight_rays.h"

#include <algorithm>
#include <array>
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
        (s.emitters.empty() ? 0u : shader::VIEW_EMITTERS) |
        (s.roundLights ? shader::VIEW_ROUND_LIGHTS : 0u) | (s.shadows ? shader::VIEW_SHADOWS : 0u) |
        (s.shadowSamples > 0 ? shader::VIEW_SHADOWS_SOFT : 0u) |
        (s.shadowMap && !s.shadowMap->tints.empty() ? shader::VIEW_SHADOWS_TINTED : 0u);
    scene.surfaceLight = {s.surfaceLight.data()};
    scene.emitters = {s.emitters.data()};
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
        scene.viewBlock.sampling = {0.0f, 1.0f, 1.0f, 0.0f};
    }
    return scene;
}

}  // namespace

glm::vec3 directionOf(const Way& way) {
    const vec3 along = shader::directionOf(way);
    return {along.x, along.y, along.z};
}

RecordedRay rayOf(const Start& start, const Way& way) {
    const shader::vec2 cone = shader::halves(start.cone);
    const shader::vec2 redGreen = shader::halves(way.shareRedGreen),
                       blueLobe = shader::halves(way.shareBlueLobe);
    return {.start = {start.position[0], start.position[1], start.position[2]},
            .along = directionOf(way),
            .share = {redGreen.x, redGreen.y, blueLobe.x},
            .width = shader::exp2(cone.y),
            .pixel = cone.x,
            .lobe = shader::abs(blueLobe.y),
            .intoBody = std::signbit(blueLobe.y)};  // -0: a smooth face
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

using shader::vectorOf;

constexpr std::size_t kFirstRays = 32;  // that are traced at once; at least those of a lobe

const std::uint32_t kNothingMet = shader::hashOfSurfaces(shader::kNoSurfaces, -1) | 1u;

// Of punctual lights that rough glass scatters, along the middle of a lobe that several paths
// share; see lightBehindGlass().
vec3 lightAlongMiddle(const RecordedRay& ray, Ray kind, vec3 toEye, std::uint32_t& paths) {
    constexpr std::uint32_t kBoth = shader::FEATURE_LIGHTS | shader::FEATURE_GLASS;
    if ((shader::scene->features & kBoth) != kBoth) return vec3(0.0f);
    shader::FirstRay round = shader::roundRayOf(ray, kind, toEye);
    shader::meet({&round, 1});
    shader::scatteredLight = vec3(0.0f);
    shader::Sum others;
    shader::addPath(others, ray, kind == Ray::transmitted, toEye, round);
    paths += others.paths;
    return shader::radianceFinite(shader::scatteredLight);
}

// first: the first rays of its paths.
Path pathOf(const RecordedRay& ray, Ray kind, vec3 toEye, std::span<const shader::FirstRay> first) {
    const bool direct = kind == Ray::transmitted;
    shader::Sum sum;
    for (const shader::FirstRay& one : first) shader::addPath(sum, ray, direct, toEye, one);
    const bool isEmpty = !(sum.weight + sum.openWeight > 1e-3f);
    if (isEmpty) {
        sum = {};
        shader::FirstRay round = shader::roundRayOf(ray, kind, toEye);
        shader::meet({&round, 1});
        shader::addPath(sum, ray, direct, toEye, round);
    } else if (sum.openWeight > 0.0f) {
        // The weight of the prefiltered map grows with the open fraction of the lobe.
        const shader::RoundLobe round = shader::roundLobeOf(ray, kind, toEye);
        const vec3 whole = shader::radianceFinite(
            shader::backgroundAtEnd(round.along, shader::coneOf(ray, round), direct));
        sum.open = shader::mix(sum.open, whole * sum.openWeight,
                               sum.openWeight / (sum.weight + sum.openWeight));
    }
    const float weight = sum.weight + sum.openWeight;
    vec3 mean = (sum.radiance + sum.open) / weight;
    if (!isEmpty && first.front().scatter.count > 1) {
        mean = mean + lightAlongMiddle(ray, kind, toEye, sum.paths);
    }
    return {{mean.x, mean.y, mean.z}, sum.surfaces | 1u, weight / sum.nearness, sum.paths};
}

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
    Path path;
    const RayWithLobe one{ray, lobe};
    follow({&one, 1}, kind, {&path, 1});
    return path;
}

void PathTracer::follow(std::span<const RayWithLobe> rays, Ray kind, std::span<Path> paths) const {
    shader::scene = scene_.get();
    std::array<shader::FirstRay, kFirstRays> firstRays;
    struct FirstRays {
        vec3 toEye;
        std::size_t count;
    };
    std::array<FirstRays, kFirstRays> ofRays;
    for (std::size_t begin = 0, end = 0; begin < rays.size(); begin = end) {
        std::size_t count = 0;
        const auto hasRoom = [&] {
            return end - begin < kFirstRays && count + shader::pathsOf(rays[end]) <= kFirstRays;
        };
        for (; end < rays.size() && hasRoom(); ++end) {
            FirstRays& own = ofRays[end - begin];
            own.toEye = scene_->toEyeFrom(vectorOf(rays[end].ray.start));
            own.count = shader::firstRaysOf(rays[end], kind, own.toEye, &firstRays[count]);
            count += own.count;
        }
        shader::meet(std::span(firstRays).first(count));
        const shader::FirstRay* first = firstRays.data();
        for (std::size_t i = begin; i < end; ++i) {
            const FirstRays& own = ofRays[i - begin];
            paths[i] = pathOf(rays[i].ray, kind, own.toEye, {first, own.count});
            first += own.count;
        }
    }
}

Path PathTracer::open(const RecordedRay& ray, Ray kind) const {
    shader::scene = scene_.get();
    const shader::RoundLobe round =
        shader::roundLobeOf(ray, kind, scene_->toEyeFrom(vectorOf(ray.start)));
    const vec3 radiance = shader::radianceFinite(
        shader::backgroundAtEnd(round.along, shader::coneOf(ray, round), kind == Ray::transmitted));
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

std::optional<SurfaceHit> PathTracer::middleOf(std::uint32_t triangle) const {
    shader::scene = scene_.get();
    return shader::middleOf(triangle);
}

}  // namespace clerestory::rays
