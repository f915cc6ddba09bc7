// The shaders' formulae of hits, light and paths as C++, over the tables of a scene, and what takes
// the place of the shaders' own traversal. A part of path.cpp; includes GLSL, so that each formula
// exists once. The scene and the state of a path are those of the thread.
#pragma once

#include "rays/hits.h"
#include "rays/record.h"
#include "rays/shader_tables.h"
#include "shaders/include/bindings.glsl"

#include <glm/gtc/packing.hpp>

#include <cmath>

namespace clerestory::rays::shader {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
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
    int triangle;
    vec2 weights;
};
Hit hitOf(const TriangleHit& hit) {
    return {hit.distance, static_cast<int>(hit.triangle), vec2(hit.u, hit.v)};
}
Hit nearest(vec3 origin, vec3 direction) {
    TriangleHit hit;
    if (!scene->triangles.tree->nearestHit(&origin.x, &direction.x, hit)) {
        return {kFarAway, -1, vec2(0.0f)};
    }
    return hitOf(hit);
}
// What the next ray meets, if that is known.
thread_local const Hit* knownHit = nullptr;
Hit traceClosest(vec3 origin, vec3 direction, float, float) {
    const Hit hit = knownHit ? *knownHit : nearest(origin, direction);
    knownHit = nullptr;
    if (firstDistance < 0.0f) firstDistance = hit.distance;
    travelled = max(travelled, 0.0f) + hit.distance;
    return hit;
}

// FNV-1a.
constexpr std::uint32_t kNoSurfaces = 2166136261u;
constexpr std::uint32_t hashOfSurfaces(std::uint32_t before, int instance) {
    return (before ^ static_cast<std::uint32_t>(instance)) * 16777619u;
}
// Of the path that the thread follows.
thread_local std::uint32_t surfaces = 0;
void noteHit(int instance) {
    surfaces = hashOfSurfaces(surfaces, instance);
}

// One of several paths that share a rough lobe; see PathTracer::follow().
struct Scatter {
    std::uint32_t count = 1, number = 0, pattern = 0;
    std::uint32_t turns = 0;  // so far
    float narrow = 1.0f;      // a path's share of the width of a lobe
};
thread_local Scatter scatter;
// Light of punctual lights that rough glass has scattered into the present path.
thread_local vec3 scatteredLight{0.0f};

// Of the present path: its primary (0 red, 1 green, 2 blue), and the first body
// that it meets whose index depends on that.
struct Dispersion {
    int primary = 1;
    float ior = 1.0f, amount = 0.0f;
};
thread_local Dispersion dispersion;

// Hooks of ray_path.glsl; the first four follow the includes.
float iorOfPath(float ior, float amount);
vec3 facetAt(vec3 normal, vec3 along, float alpha);
vec3 beyondPane(vec3 along, float lobe);
vec3 lightBehindGlass(vec3 light);
vec3 shadowAt(vec3 position, vec3 normal, vec3 source, vec3 toLight, float metres, int first);
uvec4 surfaceLightRow(int value, int row) {
    return row < SURFACE_LIGHT_ROWS
               ? texelFetch(scene->surfaceLight, SURFACE_LIGHT_ROWS * value + row)
               : texelFetch(scene->emitters, value);
}
float lobeOfPath(float lobe) {
    return lobe * scatter.narrow;
}

#define SCATTERS_LIGHTS 1
#define view (scene->viewBlock)
#define tracing (scene->tracingBlock)
#define VARIANT (scene->features)
#define HIT_LAYERS (scene->layers)
#define SHADED_LAYERS (scene->layers)
#define VIEW (scene->viewBits)
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
#define IN(type) const type&
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
#undef IN
#undef view
#undef tracing
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

}  // namespace
#pragma GCC diagnostic pop
}  // namespace clerestory::rays::shader
