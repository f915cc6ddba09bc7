// Directions of the paths that share a rough lobe or disperse. A part of path.cpp.
#pragma once

#include "rays/shader_code.h"

namespace clerestory::rays::shader {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace {

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

// Paths that share a lobe would show lights as noise; a path along its middle brings their light.
vec3 lightBehindGlass(vec3 light) {
    scatteredLight = scatteredLight + light;
    return scatter.count > 1 ? vec3(0.0f) : light;
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

// The slope of one rough face in that of two, inside a body, where rays turn less by its index;
// that of common glass.
const float kInside = kOneOfTwoFaces / 1.5f;

vec3 beyondPane(vec3 along, float lobe) {
    return withinLobe(withinLobe(along, kOneOfTwoFaces * lobe), kOneOfTwoFaces * lobe);
}

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

}  // namespace
#pragma GCC diagnostic pop
}  // namespace clerestory::rays::shader
