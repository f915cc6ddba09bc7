// Writes the rays of a pixel as records of 32 bytes, which renderer/rays/record.h reads. A ray that
// counts for less than the plan's least share sees the environment and has no record.

layout(location = 1) out uvec4 mirroredStart;
layout(location = 2) out uvec4 mirroredWay;
layout(location = 3) out uvec4 throughStart;
layout(location = 4) out uvec4 throughWay;

const PixelRay kNoRay = PixelRay(vec3(0.0f), vec3(0.0f), RayCone(0.0f, 0.0f, 0.0f), RoundLobe(vec3(0.0f), 0.0f));
PixelRay pixelRays[2] = PixelRay[2](kNoRay, kNoRay);
vec3 rayShares[2] = vec3[2](vec3(0.0f), vec3(0.0f));

vec3 tracedReflection(Surface s, vec3 position) {
    pixelRays[0] = mirroredRay(s, position);
    return vec3(0.0f);
}

GlassRays tracedThrough(Surface s, vec3 position, vec3 aside, vec3 inside, float lobe) {
    pixelRays[0] = mirroredRay(s, position);
    pixelRays[1] = transmittedRay(s, position, aside, inside, lobe);
    return GlassRays(vec3(0.0f), vec3(0.0f));
}

// Shares of the rays' radiance in that of the surface.
void weighRays(vec3 mirrored, vec3 through) {
    rayShares[0] = mirrored;
    rayShares[1] = through;
}

// A direction as a point of the octahedron's net (Cigolle et al. 2014), in [-1, 1]^2.
vec2 octahedral(vec3 v) {
    vec2 p = v.xy / max(abs(v.x) + abs(v.y) + abs(v.z), 1e-20f);
    vec2 turned = (vec2(1.0f) - abs(p.yx)) * vec2(p.x >= 0.0f ? 1.0f : -1.0f, p.y >= 0.0f ? 1.0f : -1.0f);
    return v.z < 0.0f ? turned : p;
}

// The smallest normal half float: a record with a slope as great is one.
const float kLeastPixelSlope = 6.2e-5f;

uvec4 startOf(PixelRay ray) {
    float width = clamp(log2(max(ray.cone.width, 1e-30f)), -100.0f, 100.0f);
    return uvec4(floatBitsToUint(ray.start),
                 packHalf2x16(vec2(ray.cone.pixel < 0.0f ? min(ray.cone.pixel, -kLeastPixelSlope)
                                                         : max(ray.cone.pixel, kLeastPixelSlope),
                                   width)));
}
// intoBody: through one face of a body, not through both of a pane; the sign of the slope says so.
uvec4 wayOf(PixelRay ray, vec3 share, bool intoBody) {
    float lobe = min(ray.cone.lobe, 60000.0f);
    return uvec4(floatBitsToUint(octahedral(ray.along)), packHalf2x16(share.xy),
                 packHalf2x16(vec2(share.z, intoBody ? -lobe : lobe)));
}

// Writes the records. Returns what rays without one add to the pixel. coverage: of the surface.
vec3 finishRays(float coverage) {
    vec3 added = vec3(0.0f);
    uvec4 starts[2] = uvec4[2](uvec4(0u), uvec4(0u));
    uvec4 ways[2] = uvec4[2](uvec4(0u), uvec4(0u));
    for (int i = 0; i < RAYS_OF_PIXEL; ++i) {
        vec3 share = clamp(rayShares[i] * coverage, 0.0f, 60000.0f);
        bool counts = maxComponent(share) >= tracing.limits.z && maxComponent(share) > 0.0f;
        vec3 around = environmentAlong(pixelRays[i].whole.along, min(sqrt(pixelRays[i].whole.alpha), 1.0f));
        if (i == 1 && tracing.background.w > 0.0f) around = tracing.background.xyz;
        added += counts ? vec3(0.0f) : share * around;
        starts[i] = counts ? startOf(pixelRays[i]) : uvec4(0u);
        ways[i] = counts ? wayOf(pixelRays[i], share, i == 1 && has(FEATURE_SOLID) && gl_FrontFacing) : uvec4(0u);
    }
    mirroredStart = starts[0];
    mirroredWay = ways[0];
    throughStart = starts[1];
    throughWay = ways[1];
    return added;
}
