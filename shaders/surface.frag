// A pixel of a surface: its material, the light on it, the light it gives off.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/reflection_lookup.glsl"
#include "include/distance_share.glsl"
#include "include/material.glsl"
#include "include/glass.glsl"
#include "include/lighting.glsl"
#include "include/glass_view.glsl"

out vec4 color;  // premultiplied by coverage; alpha: coverage, or how far away

// Texels along an edge of environmentBrdf.
const float kBrdfSize = 32.0f;

vec3 towardsEye() {
    return direction(mix(-positionEye, -view.forward.xyz, view.forward.w));
}

Surface surfaceAt(vec3 baseColor) {
    Surface s;
    vec2 metallicRoughness = metallicRoughnessAt();
    s.normal = normalAt();
    s.toEye = towardsEye();
    s.nDotV = max(dot(s.normal, s.toEye), kMinCosine);
    s.diffuse = baseColor * (1.0f - metallicRoughness.x);
    s.f0 = mix(material.dielectricF0.rgb, baseColor, metallicRoughness.x);
    s.roughness = metallicRoughness.y;
    vec2 brdf = textureLod(environmentBrdf,
                           environmentBrdfCoordinate(s.nDotV, s.roughness, kBrdfSize), 0.0f).rg;
    s.reflectance = specularEnvironment(s.f0, brdf);
    if (has(FEATURE_LIGHTS)) {
        float lobe = max(s.roughness, kMinRoughness);
        float alpha = lobe * lobe;
        s.alphaSquared = alpha * alpha;
        s.masking = sqrt(s.alphaSquared + (1.0f - s.alphaSquared) * s.nDotV * s.nDotV);
        s.bounces = 1.0f + s.f0 * (1.0f / clamp(brdf.x + brdf.y, 0.05f, 1.0f) - 1.0f);
    }
    return s;
}

void main() {
    vec4 base = baseColorAt();
    if (has(FEATURE_MASK) && base.a < material.emissive.w) discard;
    float coverage = has(FEATURE_BLEND) ? clamp(base.a, 0.0f, 1.0f) : 1.0f;

    vec3 radiance = base.rgb;
    if (!has(FEATURE_UNLIT)) {
        Surface s = surfaceAt(base.rgb);
        if (has(FEATURE_GLASS)) {
            Glass g = glassAt(base.rgb);
            s.diffuse *= 1.0f - g.transmission;
            radiance = lampsLight(s) + glassLight(s, positionEye, g);
        } else {
            radiance = lampsLight(s) + occlusionAt() * environmentLight(s);
        }
    }
    // Coverage dims what lies on the surface, not what it gives off.
    float alpha = has(FEATURE_BLEND) ? coverage
                                     : distanceShare(length(positionEye), view.picture.w);
    color = vec4(radianceFinite(radiance * coverage + emittedAt()), alpha);
}
