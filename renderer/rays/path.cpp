#include "rays/path.h"

#include "rays/shader_tables.h"
#include "shaders/include/bindings.glsl"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory::rays {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace shader {
namespace {

using namespace clerestory::rays::glsl;

thread_local const Scene* scene = nullptr;

// To the first surface that the path hits, and of the whole path, metres; negative before the first
// hit.
thread_local float firstDistance = -1.0f, travelled = -1.0f;
constexpr float kFarAway = 1e30f;

// In the place of trace.glsl.
struct Hit {
    float distance;
    int place;
    vec2 weights;
};
Hit nearest(vec3 origin, vec3 direction) {
    TriangleHit hit;
    if (!scene->triangles.tree->nearestHit(&origin.x, &direction.x, hit)) {
        return {kFarAway, -1, vec2(0.0f)};
    }
    return {hit.distance, static_cast<int>(hit.place), vec2(hit.u, hit.v)};
}
Hit traceClosest(vec3 origin, vec3 direction, float, float) {
    const Hit hit = nearest(origin, direction);
    if (firstDistance < 0.0f) firstDistance = hit.distance;
    travelled = max(travelled, 0.0f) + hit.distance;
    return hit;
}

// Of the path that the thread follows (FNV-1a).
thread_local std::uint32_t surfaces = 0;
void noteHit(int instance) {
    surfaces = (surfaces ^ static_cast<std::uint32_t>(instance)) * 16777619u;
}

// One of several paths that share a rough lobe; see PathTracer::follow().
struct Scatter {
    std::uint32_t count = 1, number = 0, pattern = 0;
    std::uint32_t turns = 0;  // so far
    float narrow = 1.0f;      // a path's share of the width of a lobe
};
thread_local Scatter scatter;

// Of the present path: its primary (0 red, 1 green, 2 blue), and the first body
// that it meets whose index depends on that.
struct Dispersion {
    int primary = 1;
    float ior = 1.0f, amount = 0.0f;
};
thread_local Dispersion dispersion;

// Hooks of ray_path.glsl; the first three follow the includes.
float iorOfPath(float ior, float amount);
vec3 facetAt(vec3 normal, vec3 along, float alpha);
vec3 beyondPane(vec3 along, float lobe);
vec3 shadowAt(vec3 position, vec3 normal, vec3 place, vec3 toLight, float metres, int first);
float lobeOfPath(float lobe) {
    return lobe * scatter.narrow;
}

// ---- the includes
// --------------------------------------------------------------------------------

#define view (scene->viewBlock)
#define tracing (scene->tracingBlock)
#define VARIANT (scene->features)
#define HIT_LAYERS (scene->layers)
#define SHADED_LAYERS (scene->layers)
#define VIEW (scene->viewBits)
#define surfaceLight (scene->surfaceLight)
#define traceTriangles (scene->triangles)
#define traceVertices (scene->vertices)
#define traceIndices (scene->indices)
#define traceInstances (scene->instances)
#define traceMaterials (scene->materials)
#define traceTexels (scene->texels)
#define lightTable (scene->lights)
#define environmentBrdf (scene->brdf)
#define environmentMap (scene->environment)
#define shadowMap (scene->shadowMap)
#define shadowDepths (scene->shadowDepths)
#define shadowTints (scene->shadowTints)
#define xy asXy()
#define rg asXy()
#define yz asYz()
#define zw asZw()
#define bg asBg()
#define ra asRa()
#define xyz asXyz()
#define rgb asXyz()
#define yzw asYzw()
// clang-format off
#include "include/features.glsl"
#include "include/optics.glsl"
#include "include/sampling.glsl"
#include "include/material_point.glsl"
#include "include/glass.glsl"
#define shadowAt shadowInMap
#include "include/shadow.glsl"
#undef shadowAt
#include "include/lighting.glsl"
#include "include/ray.glsl"
#include "include/hit.glsl"
#include "include/ray_path.glsl"
// clang-format on
vec3 eyeAxesOf(vec3 world) {
    return direction(eyeAxes(world));
}
#undef view
#undef tracing
#undef surfaceLight
#undef shadowMap
#undef shadowDepths
#undef shadowTints
#undef xy
#undef rg
#undef yz
#undef zw
#undef bg
#undef ra
#undef xyz
#undef rgb
#undef yzw

// The inverse of octahedral() in ray_record.glsl.
vec3 directionOf(const Way& way) {
    const vec2 p(way.octahedral[0], way.octahedral[1]);
    vec3 v(p.x, p.y, 1.0f - abs(p.x) - abs(p.y));
    if (v.z < 0.0f) {
        v.x = (1.0f - abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f);
        v.y = (1.0f - abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f);
    }
    return normalize(v);
}

vec2 halves(std::uint32_t packed) {
    const glm::vec2 v = glm::unpackHalf2x16(packed);
    return {v.x, v.y};
}

// ---- rough lobes
// --------------------------------------------------------------------------------

// Paths of neighbouring pixels have other directions, and their mean is taken (follow.cpp), so a
// path represents less than its pixel's share of the lobe.
constexpr float kPathsOfNeighbours = 2.0f;

float fractionOf(float x) {
    return x - floor(x);
}

// Two numbers in [0, 1) of the present path, for each turn another pair: a Hammersley set for the
// pixel, moved by another step of a sequence with even gaps (Roberts 2018) for each pattern;
// further turns by a hash, so that no two turns belong together.
vec2 numbersOfTurn() {
    const std::uint32_t turn = scatter.turns++;
    std::uint32_t number = scatter.number, step = scatter.pattern;
    if (turn > 0) {
        std::uint32_t h = (step * 16u + number) * 747796405u + turn * 2891336453u;
        h = ((h >> ((h >> 28u) + 4u)) ^ h) * 277803737u;
        h ^= h >> 22u;
        return {static_cast<float>(h & 0xffffu) / 65536.0f,
                static_cast<float>(h >> 16u) / 65536.0f};
    }
    const vec2 u = hammersley(number, scatter.count);
    return {fractionOf(u.x + 0.75487767f * static_cast<float>(step)),
            fractionOf(u.y + 0.56984029f * static_cast<float>(step))};
}

// A microfacet normal, sampled from those visible along `along`; the surface's own if a single path
// represents the lobe.
vec3 facetAt(vec3 normal, vec3 along, float alpha) {
    if (scatter.count <= 1 || !(alpha > 0.0f)) return normal;
    const mat3 frame = frameAbout(normal);
    const vec3 v(-dot(frame[0], along), -dot(frame[1], along), max(-dot(frame[2], along), 0.0f));
    return direction(frame * ggxVisibleNormal(numbersOfTurn(), normalize(v), alpha));
}

// A direction of a cone whose slopes are distributed as those of GGX.
vec3 withinLobe(vec3 along, float lobe) {
    if (scatter.count <= 1 || !(lobe > 0.0f)) return along;
    const vec2 u = numbersOfTurn();
    const float slope = lobe * sqrt(u.y / max(1.0f - u.y, 1e-6f));
    const mat3 frame = frameAbout(along);
    return direction(along + frame[0] * (slope * cos(2.0f * kPi * u.x)) +
                     frame[1] * (slope * sin(2.0f * kPi * u.x)));
}

// Slope of one rough face in that of two (glassSpread()), and of one inside a body, where rays turn
// less by its index; that of common glass.
constexpr float kOneOfTwoFaces = 0.57735027f;
constexpr float kInside = kOneOfTwoFaces / 1.5f;

vec3 beyondPane(vec3 along, float lobe) {
    return withinLobe(withinLobe(along, kOneOfTwoFaces * lobe), kOneOfTwoFaces * lobe);
}

// ---- dispersion
// --------------------------------------------------------------------------------

float iorOf(int primary, float ior, float amount) {
    const vec3 iors = dispersedIors(ior, amount);
    return primary == 0 ? iors.x : primary == 1 ? ior : iors.z;
}

float iorOfPath(float ior, float amount) {
    if (amount > 0.0f && dispersion.amount == 0.0f) {
        dispersion.ior = ior;
        dispersion.amount = amount;
    }
    return iorOf(dispersion.primary, ior, amount);
}

// Direction in the body for another primary. along: that of green. The surface's normal is in the
// plane of both and the line of sight.
vec3 dispersedInside(vec3 along, vec3 toEye, int primary) {
    const vec3 bend = -toEye - along * dispersion.ior;
    if (!(dot(bend, bend) > 1e-12f)) return along;  // straight ahead
    const vec3 normal = direction(dot(bend, toEye) > 0.0f ? bend : -bend);
    return refracted(-toEye, normal, iorOf(primary, dispersion.ior, dispersion.amount)).direction;
}

struct Sum {
    vec3 radiance = vec3(0.0f), open = vec3(0.0f);  // open: of paths that met nothing at first
    float weight = 0.0f, openWeight = 0.0f, nearness = 0.0f;
    std::uint32_t surfaces = 2166136261u;
    std::uint32_t paths = 0;
};

// Each path of `ray` leaves towards `toEye` at its start.
void addPath(Sum& sum, const RecordedRay& ray, bool direct, vec3 along, vec3 toEye, RayCone cone,
             float weight) {
    const vec3 start(ray.start.x, ray.start.y, ray.start.z);
    const float share = max(ray.share.x, max(ray.share.y, ray.share.z));
    surfaces = sum.surfaces;
    firstDistance = travelled = -1.0f;
    dispersion = {};
    vec3 radiance = radianceFinite(tracedRadiance(start, along, cone, share, direct));
    if (dispersion.amount > 0.0f) {
        const float first = firstDistance, whole = travelled;
        for (const int primary : {0, 2}) {
            dispersion.primary = primary;
            const vec3 bent = ray.intoBody ? dispersedInside(along, toEye, primary) : along;
            const vec3 light = radianceFinite(tracedRadiance(start, bent, cone, share, direct));
            (primary == 0 ? radiance.x : radiance.z) = primary == 0 ? light.x : light.z;
        }
        firstDistance = first;
        travelled = whole;
    }
    radiance = radiance * weight;
    const bool open = firstDistance >= kFarAway;
    (open ? sum.open : sum.radiance) += radiance;
    (open ? sum.openWeight : sum.weight) += weight;
    // In a body a lobe is narrow; what is behind it matters.
    sum.nearness += weight / max(ray.intoBody ? travelled : firstDistance, 1e-12f);
    sum.surfaces = surfaces;
    ++sum.paths;
}

struct LobeRay {
    vec3 along;
    float weight = 0.0f;  // 0: does not leave the surface
    float lobe = 0.0f;    // slope of the cone that it represents
};

// A mirror's direction, sampled from the microfacet normals that are visible from the eye. The
// weight of each is its unmasked fraction.
LobeRay mirroredInLobe(vec3 along, vec3 toEye, float lobe) {
    const float alpha = 0.5f * lobe;
    const vec3 normal = direction(along + toEye);
    const float nDotV = dot(normal, toEye);
    // x towards the eye, so that the pattern turns with the surface and not with the frame.
    vec3 side = toEye - normal * nDotV;
    side = dot(side, side) > 1e-8f ? direction(side) : frameAbout(normal)[0];
    const mat3 frame(side, cross(normal, side), normal);
    const vec3 v(sqrt(max(1.0f - nDotV * nDotV, 0.0f)), 0.0f, nDotV);
    const vec3 h = ggxVisibleNormal(numbersOfTurn(), v, alpha);
    const vec3 l = reflect(-v, h);
    const float density = ggxVisibleDensity(h.z, h.x * h.x + h.y * h.y, nDotV, alpha);
    const float roughness =
        sampleRoughness(density, kPathsOfNeighbours * static_cast<float>(scatter.count));
    return {direction(frame * l), l.z > 0.0f ? ggxShareOfVisible(l.z, nDotV, alpha) : 0.0f,
            min(2.0f * roughness * roughness, lobe)};
}

LobeRay transmittedInLobe(vec3 along, float lobe, bool intoBody) {
    const vec3 next = intoBody ? withinLobe(along, kInside * lobe) : beyondPane(along, lobe);
    return {next, 1.0f, lobe * scatter.narrow};
}

SurfaceHit surfaceAlong(vec3 start, vec3 along, RayCone cone, float limit);

// Whether a ray may pass the surface: holes, blended surfaces, glass.
bool mayPass(const Hit& hit) {
    const BvhTriangle& t = scene->triangles.tree->triangle(static_cast<std::uint32_t>(hit.place));
    const int place = TRACE_INSTANCE_ROWS * static_cast<int>(t.instance);
    const int m = TRACE_MATERIAL_ROWS * static_cast<int>(texelFetch(scene->instances, place).w);
    const int flags = static_cast<int>(texelFetch(scene->materials, m + 5).w) |
                      static_cast<int>(texelFetch(scene->instances, place + 5).w);
    return (flags & (TRACE_MASK | TRACE_BLEND | TRACE_PANE | TRACE_SOLID)) != 0;
}

vec3 shadowAt(vec3 position, vec3 normal, vec3 place, vec3 toLight, float metres, int first) {
    if (scene->shadowMap.map) {
        return shadowInMap(position, normal, place, toLight, metres, first);
    }
    if (dot(normal, toLight) <= 0.0f) return vec3(1.0f);  // nothing arrives there
    const float limit = metres > 0.0f ? metres * 0.9999f : 1e30f;
    const vec3 eye(scene->tracingBlock.eye.x, scene->tracingBlock.eye.y, scene->tracingBlock.eye.z);
    const vec3 at = eye + worldAxes(position);
    const float reach = max(abs(at.x), max(abs(at.y), abs(at.z)));
    const vec3 start = offsetRayOrigin(at, normal, reach + 5.0f * length(position));
    const Hit hit = nearest(start, worldAxes(toLight));
    if (hit.place < 0 || hit.distance >= limit) return vec3(1.0f);
    if (!mayPass(hit)) return vec3(0.0f);
    const SurfaceHit met = surfaceAlong(start, toLight, {0.0f, 0.0f, 0.0f}, limit);
    return met.met ? vec3(0.0f) : vec3(met.share.x, met.share.y, met.share.z);
}

glm::vec3 plain(vec3 v) {
    return {v.x, v.y, v.z};
}

// Fills in what the surface is.
void describe(const Hit& hit, const HitPoint& p, SurfaceHit& result) {
    const auto place = static_cast<std::uint32_t>(hit.place);
    const auto triangle = static_cast<std::size_t>(scene->triangles.tree->triangle(place).triangle);
    for (std::size_t k = 0; k < 3; ++k) {
        result.vertices[k] = scene->indices.data[3 * triangle + k];
    }
    result.weights[1] = hit.weights.x;
    result.weights[2] = hit.weights.y;
    result.weights[0] = 1.0f - hit.weights.x - hit.weights.y;
    result.met = true;
    result.instance = static_cast<std::uint32_t>(p.instance);
    const MaterialPoint& m = p.material;
    result.normal = plain(m.normal);
    const vec3 color(m.baseColor.x, m.baseColor.y, m.baseColor.z);
    const vec3 f0 = mix(m.dielectricF0, color, m.metallic);
    const vec3 diffuse = color * (1.0f - m.metallic);
    const bool unlit = (p.flags & TRACE_UNLIT) != 0;
    result.albedo = unlit ? glm::vec3(0.0f)
                          : plain(clamp(diffuse * (1.0f - maxComponent(f0)) + f0, 0.0f, 1.0f));
    result.emitted = plain(unlit ? color : m.emitted);
}

std::optional<SurfaceHit> middleOf(std::uint32_t place) {
    const BvhTriangle& t = scene->triangles.tree->triangle(place);
    const glm::vec3 face = glm::cross(t.b - t.a, t.c - t.a);
    const float twiceArea = glm::length(face);
    if (!(twiceArea > 0.0f)) return std::nullopt;
    const glm::vec3 n = face / twiceArea;
    const Hit hit{0.0f, static_cast<int>(place), vec2(1.0f / 3.0f)};
    const HitPoint p = hitPoint(hit, eyeAxes(vec3(-n.x, -n.y, -n.z)), std::sqrt(twiceArea));
    const int passed = TRACE_MASK | TRACE_BLEND | TRACE_PANE | TRACE_SOLID;
    if ((p.flags & passed) != 0) return std::nullopt;
    SurfaceHit result;
    describe(hit, p, result);
    return result;
}

// Surfaces that a ray passes.
constexpr int kMaxSurfaces = 24;

// Whether the hit is ignored: the back of a one-sided surface, or a hole.
bool isAbsent(const HitPoint& p) {
    const bool back = !p.front && (p.flags & (TRACE_DOUBLE_SIDED | TRACE_SOLID)) == 0;
    return back || p.material.baseColor.w < p.cutoff;
}

std::optional<PointHit> pointAlong(vec3 start, vec3 along, RayCone cone) {
    for (int passed = 0; passed < kMaxSurfaces; ++passed) {
        const Hit hit = nearest(start, worldAxes(along));
        if (hit.place < 0) return std::nullopt;
        cone.width += cone.pixel * hit.distance;
        const HitPoint p = hitPoint(hit, along, cone.width);
        if (isAbsent(p)) {
            start = offsetRayOrigin(p.place, -p.faceNormal, p.reach);
            continue;
        }
        const BvhTriangle& t =
            scene->triangles.tree->triangle(static_cast<std::uint32_t>(hit.place));
        const vec4 color = p.material.baseColor;
        return PointHit{static_cast<std::uint32_t>(p.instance),
                        static_cast<std::uint32_t>(t.triangle), p.front,
                        glm::vec3(color.x, color.y, color.z)};
    }
    return std::nullopt;
}

// A body that a ray is in. distance: as absorption() takes it; 0: none.
struct Medium {
    vec3 color{1.0f};
    float distance = 0.0f;
};
Medium mediumOf(const HitPoint& p) {
    return {p.attenuation, p.glass.w};
}

// Transmittance of a pane, or of one face of a body, for light that is not refracted. clarity: the
// fraction of the surface that transmits light.
vec3 throughFace(const HitPoint& p, vec3 along, float clarity) {
    const MaterialPoint& m = p.material;
    const bool solid = (p.flags & TRACE_SOLID) != 0;
    const vec3 normal = dot(m.normal, along) < 0.0f ? m.normal : p.faceNormal;
    const float fresnel = fresnelOfBody(-dot(along, normal), max(p.glass.y, 1.0f), m.specular);
    if (solid && !p.front) return vec3(clarity * (1.0f - fresnel));
    const vec3 color(m.baseColor.x, m.baseColor.y, m.baseColor.z);
    if (solid) return color * (clarity * (1.0f - fresnel));
    const Crossing way = throughPane(along, normal, p.glass.y, p.glass.z);
    const vec3 clear = absorption(p.attenuation, p.glass.w, way.path);
    return clarity * color * paneShares(fresnel, clear).transmitted;
}

// See PathTracer::surfaceAlong().
SurfaceHit surfaceAlong(vec3 start, vec3 along, RayCone cone, float limit) {
    SurfaceHit result;
    vec3 share(1.0f);
    Medium medium;
    float left = limit;
    for (int passed = 0; passed < kMaxSurfaces && maxComponent(share) > 1e-3f; ++passed) {
        const Hit hit = nearest(start, worldAxes(along));
        if (hit.place < 0 || hit.distance >= left) {
            result.share = plain(share);
            return result;
        }
        result.distance += hit.distance;
        left -= hit.distance;
        cone.width += cone.pixel * hit.distance;
        const HitPoint p = hitPoint(hit, along, cone.width);
        const MaterialPoint& m = p.material;
        const bool leaves = (p.flags & TRACE_SOLID) != 0 && !p.front;
        if (leaves && medium.distance == 0.0f) medium = mediumOf(p);  // the ray began inside
        share *= absorption(medium.color, medium.distance, hit.distance);
        const bool back = !p.front && (p.flags & (TRACE_DOUBLE_SIDED | TRACE_SOLID)) == 0;
        if (back && passed == 0) result.begins = false;
        if (isAbsent(p)) {
            start = offsetRayOrigin(p.place, -p.faceNormal, p.reach);
            continue;
        }
        const bool glass = (p.flags & (TRACE_SOLID | TRACE_PANE)) != 0;
        const float clarity = glass ? clearShare(p.glass.x, m.metallic) : 0.0f;
        const float coverage =
            (p.flags & TRACE_BLEND) != 0 ? clamp(m.baseColor.w, 0.0f, 1.0f) : 1.0f;
        if (clarity > 0.5f || coverage < 0.5f) {
            const vec3 covered = glass ? throughFace(p, along, clarity) : vec3(0.0f);
            share *= covered * coverage + vec3(1.0f - coverage);
            if (glass && (p.flags & TRACE_SOLID) != 0) medium = leaves ? Medium{} : mediumOf(p);
            start = offsetRayOrigin(p.place, -p.faceNormal, p.reach);
            continue;
        }
        result.share = plain(share);
        describe(hit, p, result);
        return result;
    }
    result.met = true;
    result.share = glm::vec3(0.0f);
    return result;
}

}  // namespace
}  // namespace shader
#pragma GCC diagnostic pop

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
};

PathTracer::PathTracer(const Surroundings& surroundings)
    : scene_(new Scene{sceneOf(surroundings)}) {
    const glm::vec3 b = surroundings.towardsEye;
    scene_->backwards = {b.x, b.y, b.z};
}
PathTracer::~PathTracer() = default;

Path PathTracer::follow(const RecordedRay& ray, Ray kind, const Lobe& lobe) const {
    shader::scene = scene_.get();
    shader::scatter = {};
    const vec3 start(ray.start.x, ray.start.y, ray.start.z),
        along(ray.along.x, ray.along.y, ray.along.z);
    shader::Sum sum;
    const bool direct = kind == Ray::transmitted;
    const bool perspective = shader::dot(scene_->backwards, scene_->backwards) == 0.0f;
    const vec3 eye(scene_->tracingBlock.eye.x, scene_->tracingBlock.eye.y,
                   scene_->tracingBlock.eye.z);
    const vec3 toEye = shader::eyeAxesOf(perspective ? eye - start : scene_->backwards);
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
    const shader::RayCone cone = {ray.width, ray.pixel, ray.lobe};
    if (!(sum.weight + sum.openWeight > 1e-3f)) {
        shader::scatter = {};
        sum = {};
        shader::addPath(sum, ray, direct, along, toEye, cone, 1.0f);
    } else if (sum.openWeight > 0.0f) {
        // The weight of the prefiltered map grows with the open fraction of the lobe.
        const vec3 whole = shader::radianceFinite(shader::backgroundAtEnd(along, cone, direct));
        sum.open = shader::mix(sum.open, whole * sum.openWeight,
                               sum.openWeight / (sum.weight + sum.openWeight));
    }
    const float weight = sum.weight + sum.openWeight;
    const vec3 mean = (sum.radiance + sum.open) / weight;
    return {{mean.x, mean.y, mean.z}, sum.surfaces | 1u, weight / sum.nearness, sum.paths};
}

SurfaceHit PathTracer::surfaceAlong(const glm::vec3& start, const glm::vec3& along, float width,
                                    float spread, float limit) const {
    shader::scene = scene_.get();
    return shader::surfaceAlong({start.x, start.y, start.z}, {along.x, along.y, along.z},
                                {width, spread, 0.0f}, limit);
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
