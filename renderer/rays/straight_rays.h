// Rays that are not refracted: to lights, and of light between surfaces. They pass holes, blended
// surfaces and glass, which absorb a part of their light. A part of path.cpp.
#pragma once

#include "rays/shader_code.h"

namespace clerestory::rays::shader {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace {

SurfaceHit surfaceAlong(vec3 start, vec3 along, RayCone cone, float limit, Hit hit);

// Whether a ray may pass the surface: holes, blended surfaces, glass.
bool mayPass(const Hit& hit) {
    const BvhTriangle& t =
        scene->triangles.tree->triangle(static_cast<std::uint32_t>(hit.triangle));
    const int row = TRACE_INSTANCE_ROWS * static_cast<int>(t.instance);
    const int m = TRACE_MATERIAL_ROWS * static_cast<int>(texelFetch(scene->instances, row).w);
    const int flags = static_cast<int>(texelFetch(scene->materials, m + 5).w) |
                      static_cast<int>(texelFetch(scene->instances, row + 5).w);
    return (flags & (TRACE_MASK | TRACE_BLEND | TRACE_PANE | TRACE_SOLID)) != 0;
}

vec3 shadowAt(vec3 position, vec3 normal, vec3 source, vec3 toLight, float metres, int first) {
    if (scene->shadowMap.map) {
        return shadowInMap(position, normal, source, toLight, metres, first);
    }
    if (dot(normal, toLight) <= 0.0f) return vec3(1.0f);  // nothing arrives there
    const float limit = metres > 0.0f ? metres * 0.9999f : 1e30f;
    const vec3 eye(scene->tracingBlock.eye.x, scene->tracingBlock.eye.y, scene->tracingBlock.eye.z);
    const vec3 at = eye + worldAxes(position);
    const float reach = max(abs(at.x), max(abs(at.y), abs(at.z)));
    const vec3 start = offsetRayOrigin(at, normal, reach + 5.0f * length(position));
    const Hit hit = nearest(start, worldAxes(toLight));
    if (hit.triangle < 0 || hit.distance >= limit) return vec3(1.0f);
    if (!mayPass(hit)) return vec3(0.0f);
    const SurfaceHit met = surfaceAlong(start, toLight, {0.0f, 0.0f, 0.0f}, limit, hit);
    return met.met ? vec3(0.0f) : vec3(met.share.x, met.share.y, met.share.z);
}

float lightBeforeFarWall(vec3, vec3, float) {
    return 1.0f;  // paths tell no near walls
}

glm::vec3 plain(vec3 v) {
    return {v.x, v.y, v.z};
}

// Fills in what the surface is.
void describe(const Hit& hit, const HitPoint& p, SurfaceHit& result) {
    const auto inTree = static_cast<std::uint32_t>(hit.triangle);
    const auto triangle =
        static_cast<std::size_t>(scene->triangles.tree->triangle(inTree).triangle);
    for (std::size_t k = 0; k < 3; ++k) {
        result.vertices[k] = scene->indices.data[3 * triangle + k];
    }
    result.weights[1] = hit.weights.x;
    result.weights[2] = hit.weights.y;
    result.weights[0] = 1.0f - hit.weights.x - hit.weights.y;
    result.met = true;
    result.instance = static_cast<std::uint32_t>(p.instance);
    result.face = inTree;
    const MaterialPoint& m = p.material;
    result.normal = plain(m.normal);
    const vec3 color(m.baseColor.x, m.baseColor.y, m.baseColor.z);
    const vec3 f0 = mix(m.dielectricF0, color, m.metallic);
    const bool unlit = (p.flags & TRACE_UNLIT) != 0;
    const bool transmits = hitLayered(LAYER_DIFFUSE_TRANSMISSION);
    const float throughShare = transmits ? m.layers.throughShare : 0.0f;
    const float below = (1.0f - m.metallic) * (1.0f - maxComponent(f0));
    result.albedo = unlit ? glm::vec3(0.0f)
                          : plain(clamp(color * ((1.0f - throughShare) * below) + f0, 0.0f, 1.0f));
    if (transmits && !unlit) {
        result.through = plain(clamp(m.layers.through * (throughShare * below), 0.0f, 1.0f));
    }
    result.emitted = plain(unlit ? color : m.emitted);
}

std::optional<SurfaceHit> middleOf(std::uint32_t triangle) {
    const BvhTriangle& t = scene->triangles.tree->triangle(triangle);
    const glm::vec3 face = glm::cross(t.b - t.a, t.c - t.a);
    const float twiceArea = glm::length(face);
    if (!(twiceArea > 0.0f)) return std::nullopt;
    const glm::vec3 n = face / twiceArea;
    const Hit hit{0.0f, static_cast<int>(triangle), vec2(1.0f / 3.0f)};
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
        if (hit.triangle < 0) return std::nullopt;
        cone = coneAfter(cone, hit.distance);
        const HitPoint p = hitPoint(hit, along, cone.width);
        if (isAbsent(p)) {
            start = offsetRayOrigin(p.position, -p.faceNormal, p.reach);
            continue;
        }
        const BvhTriangle& t =
            scene->triangles.tree->triangle(static_cast<std::uint32_t>(hit.triangle));
        const vec4 color = p.material.baseColor;
        return PointHit{static_cast<std::uint32_t>(p.instance),
                        static_cast<std::uint32_t>(t.triangle), p.front, plain(p.material.normal),
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

// See PathTracer::surfaceAlong(). hit: the nearest one.
SurfaceHit surfaceAlong(vec3 start, vec3 along, RayCone cone, float limit, Hit hit) {
    SurfaceHit result;
    vec3 share(1.0f);
    Medium medium;
    float left = limit;
    for (int passed = 0; passed < kMaxSurfaces && maxComponent(share) > 1e-3f; ++passed) {
        if (passed > 0) hit = nearest(start, worldAxes(along));
        if (hit.triangle < 0 || hit.distance >= left) {
            result.share = plain(share);
            return result;
        }
        result.distance += hit.distance;
        left -= hit.distance;
        cone = coneAfter(cone, hit.distance);
        const HitPoint p = hitPoint(hit, along, cone.width);
        const MaterialPoint& m = p.material;
        const bool leaves = (p.flags & TRACE_SOLID) != 0 && !p.front;
        if (leaves && medium.distance == 0.0f) medium = mediumOf(p);  // the ray began inside
        share *= absorption(medium.color, medium.distance, hit.distance);
        const bool back = !p.front && (p.flags & (TRACE_DOUBLE_SIDED | TRACE_SOLID)) == 0;
        const bool pane = (p.flags & TRACE_PANE) != 0;  // has no inside
        if (back && !pane && passed == 0) result.begins = false;
        if (isAbsent(p)) {
            start = offsetRayOrigin(p.position, -p.faceNormal, p.reach);
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
            start = offsetRayOrigin(p.position, -p.faceNormal, p.reach);
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
#pragma GCC diagnostic pop
}  // namespace clerestory::rays::shader
