// The first rays of the paths of several pixels, what they meet, and the sum of the paths' light. A
// part of path.cpp.
#pragma once

#include "rays/lobes.h"
#include "rays/record.h"

#include <span>

namespace clerestory::rays::shader {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace {

struct FirstRay {
    vec3 start, along;  // as tracedRadiance() takes them
    RayCone cone;
    float weight;     // of the path
    Scatter scatter;  // after the choice of `along`
    Hit hit;
};

vec3 vectorOf(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}

// The lobe as one direction with a width.
RoundLobe roundLobeOf(const RecordedRay& ray, Ray kind, vec3 toEye) {
    const vec3 along = vectorOf(ray.along);
    if (kind == Ray::mirrored) return mirroredLobe(along, toEye, ray.lobe);
    return {along, 0.5f * ray.lobe};
}

RayCone coneOf(const RecordedRay& ray, const RoundLobe& round) {
    return {ray.width, ray.pixel, 2.0f * round.alpha};
}

FirstRay roundRayOf(const RecordedRay& ray, Ray kind, vec3 toEye) {
    const RoundLobe round = roundLobeOf(ray, kind, toEye);
    return {vectorOf(ray.start), round.along, coneOf(ray, round), 1.0f, {}, {}};
}

bool sharesLobe(const RayWithLobe& r) {
    return r.lobe.paths > 1 && isRough(r.ray);
}
std::size_t pathsOf(const RayWithLobe& r) {
    return sharesLobe(r) ? r.lobe.paths : 1;
}

// Writes to `rays`, which has room for pathsOf(r), and returns their number. Directions of a lobe
// below the surface are left out.
std::size_t firstRaysOf(const RayWithLobe& r, Ray kind, vec3 toEye, FirstRay* rays) {
    const RecordedRay& ray = r.ray;
    if (!sharesLobe(r)) {
        rays[0] = roundRayOf(ray, kind, toEye);
        return 1;
    }
    const vec3 along = vectorOf(ray.along);
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < r.lobe.paths; ++i) {
        scatter = {r.lobe.paths, i, r.lobe.pattern, 0,
                   1.0f / std::sqrt(kPathsOfNeighbours * static_cast<float>(r.lobe.paths))};
        const LobeRay next = kind == Ray::mirrored
                                 ? mirroredInLobe(along, toEye, ray.lobe)
                                 : transmittedInLobe(along, ray.lobe, ray.intoBody);
        if (next.weight <= 0.0f) continue;
        rays[count++] = {vectorOf(ray.start), next.along, {ray.width, ray.pixel, next.lobe},
                         next.weight,         scatter,    {}};
    }
    return count;
}

constexpr std::uintptr_t kCacheLine = 64;  // bytes

void prefetch(const void* data, std::size_t bytes) {
    const auto first = reinterpret_cast<std::uintptr_t>(data) / kCacheLine * kCacheLine;
    const auto end = reinterpret_cast<std::uintptr_t>(data) + bytes;
    for (auto line = first; line < end; line += kCacheLine) {
        __builtin_prefetch(reinterpret_cast<const void*>(line));
    }
}

// Finds the hits. What hitPoint() will read of them is in memory far away, and the place of each
// part is in another part: each is requested for all rays before the next is read for any.
void meet(std::span<FirstRay> rays) {
    const auto triangleOf = [](const FirstRay& r) -> const BvhTriangle& {
        return scene->triangles.tree->triangle(static_cast<std::uint32_t>(r.hit.triangle));
    };
    const auto cornersOf = [&](const FirstRay& r) {
        return scene->indices.data + 3 * static_cast<std::size_t>(triangleOf(r).triangle);
    };
    const auto each = [&](auto&& request) {
        for (const FirstRay& r : rays) {
            if (r.hit.triangle >= 0) request(r);
        }
    };
    for (FirstRay& r : rays) {
        r.hit = nearest(r.start, worldAxes(r.along));
        if (r.hit.triangle >= 0) prefetch(&triangleOf(r), sizeof(BvhTriangle));
    }
    each([&](const FirstRay& r) { prefetch(cornersOf(r), 3 * sizeof(std::uint32_t)); });
    each([&](const FirstRay& r) {
        const auto instance = static_cast<int>(triangleOf(r).instance);
        const float firstLight = texelFetch(scene->instances, TRACE_INSTANCE_ROWS * instance + 6).x;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t vertex = cornersOf(r)[k];
            constexpr std::size_t kFloats = std::size_t{2} * TRACE_VERTEX_PAIRS;
            prefetch(scene->vertices.data + kFloats * vertex, kFloats * sizeof(float));
            if ((scene->viewBits & VIEW_SURFACE_LIGHT) == 0) continue;
            constexpr std::size_t kWords = std::size_t{4} * SURFACE_LIGHT_ROWS;
            const int value = surfaceLightValue(firstLight, static_cast<int>(vertex));
            prefetch(scene->surfaceLight.data + kWords * static_cast<std::size_t>(value),
                     kWords * sizeof(std::uint32_t));
        }
    });
}

struct Sum {
    vec3 radiance = vec3(0.0f), open = vec3(0.0f);  // open: of paths that met nothing at first
    float weight = 0.0f, openWeight = 0.0f, nearness = 0.0f;
    std::uint32_t surfaces = kNoSurfaces;
    std::uint32_t paths = 0;
};

// Each path of `ray` leaves towards `toEye` at its start.
void addPath(Sum& sum, const RecordedRay& ray, bool direct, vec3 toEye, const FirstRay& first) {
    const float share = max(ray.share.x, max(ray.share.y, ray.share.z));
    surfaces = sum.surfaces;
    firstDistance = travelled = -1.0f;
    dispersion = {};
    scatter = first.scatter;
    knownHit = &first.hit;
    vec3 radiance =
        radianceFinite(tracedRadiance(first.start, first.along, first.cone, share, direct));
    if (dispersion.amount > 0.0f) {
        const float toFirst = firstDistance, whole = travelled;
        for (const int primary : {0, 2}) {
            dispersion.primary = primary;
            const vec3 bent =
                ray.intoBody ? dispersedInside(first.along, toEye, primary) : first.along;
            const vec3 light =
                radianceFinite(tracedRadiance(first.start, bent, first.cone, share, direct));
            (primary == 0 ? radiance.x : radiance.z) = primary == 0 ? light.x : light.z;
        }
        firstDistance = toFirst;
        travelled = whole;
    }
    radiance = radiance * first.weight;
    const bool open = firstDistance >= kFarAway;
    (open ? sum.open : sum.radiance) += radiance;
    (open ? sum.openWeight : sum.weight) += first.weight;
    // In a body a lobe is narrow; what is behind it matters.
    sum.nearness += first.weight / max(ray.intoBody ? travelled : firstDistance, 1e-12f);
    sum.surfaces = surfaces;
    ++sum.paths;
}

}  // namespace
#pragma GCC diagnostic pop
}  // namespace clerestory::rays::shader
