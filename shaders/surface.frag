// A pixel of a surface: its material, the light that it reflects and transmits, its emission.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#include "include/light_samplers.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/sampling.glsl"
#include "include/reflection_lookup.glsl"
#include "include/distance_share.glsl"
#include "include/material.glsl"
#if SHADES_GLASS || TRACES_RAYS
#include "include/glass.glsl"
#endif
#define SCATTERS_LIGHTS (SHADES_GLASS || (TRACES_RAYS && !RECORDS_RAYS))
#include "include/shadow.glsl"
#include "include/lighting.glsl"
#if TRACES_RAYS
#include "include/ray_start.glsl"
#else
#include "include/no_rays.glsl"
#endif
#include "include/reflection.glsl"
#include "include/catcher.glsl"

out vec4 color;  // premultiplied by coverage; alpha: coverage, or the stored distance

vec3 towardsEye() {
    return viewHas(VIEW_ORTHOGRAPHIC) ? -view.forward.xyz : direction(-positionEye);
}

// Within a pixel, half vectors vary relative to the surface as its normals do, and half as much as the
// direction of view.
Surface coveredByPixel(Surface s) {
    vec3 shape = direction(vertexNormal);
    vec3 ahead = viewHas(VIEW_ORTHOGRAPHIC) ? view.forward.xyz : direction(positionEye);
    vec3 turned = shape + 0.5f * ahead;
    float part = view.sampling.x;
    vec3 x = dFdx(turned);
    vec3 y = dFdy(turned);
    s = covering(s, scaled(turnAt(x, y, s.normal, s.roughness), part),
                 scaled(clearcoatTurnAt(x, y, s.layers), part));
    // The roughness of most materials with default factors varies, and a software rasteriser skips
    // what no pixel needs.
    if (has(FEATURE_NORMAL_MAP) && has(FEATURE_DEFAULT_NUMBERS) && !layered(LAYER_CLEARCOAT)) {
        s.averages = s.roughness < 2.0f * kGlintRoughness;
    }
    return s;
}

vec3 punctualLightOn(Surface s, vec3 position) {
    if (viewHas(VIEW_SUN_ONLY)) return sunLight(s, position, HARMONIC_ROWS);
    const int first = int((uint(VIEW) >> VIEW_LIGHTS_SHIFT) & VIEW_LIGHTS_MASK);
    if (first > 0) return firstPunctualLights(s, position, first);
    return punctualLights(s, position, int(drawNumbers.x), int(drawNumbers.y));
}

vec3 punctualLightAt(Surface s) {
    if (!has(FEATURE_LIGHTS)) return vec3(0.0f);
    if (!has(FEATURE_WIDE_LOBE) || layered(LAYER_CLEARCOAT)) s = coveredByPixel(s);
    return punctualLightOn(s, positionEye);
}

// Of a shell, whose walls are drawn apart; see drawNumbers.
bool isNearWall() {
    return fract(2.0f * drawNumbers.y) >= 0.5f;
}
bool isFarWall() {
    return fract(4.0f * drawNumbers.y) >= 0.5f;
}

#if SHADES_GLASS
#include "include/glass_view.glsl"
#else
#include "include/no_glass.glsl"
#endif

// Light of the surroundings of a base below sheen or a coat. Unoccluded fractions: ofPicture of the
// reflection, occlusion of the rest.
vec3 layeredLight(Surface s, vec3 mirrored, float ofPicture, float occlusion) {
    vec3 coat = vec3(s.clearcoatReflectance);
    vec3 below = vec3(s.belowSheen * s.belowClearcoat) * s.reflectance;
    weighRays(layered(LAYER_CLEARCOAT_MIRRORS) ? coat
              : layered(LAYER_CLEARCOAT)       ? below + coat
                                               : below,
              vec3(0.0f));
    vec3 base = s.reflectance * mirrored * (layered(LAYER_CLEARCOAT_MIRRORS) ? occlusion : ofPicture);
    vec3 light = underCoat(s, base + occlusion * diffuseLight(s));
    if (layered(LAYER_CLEARCOAT)) {
        light += coat * clearcoatRadiance(s, positionEye, mirrored) * ofPicture;
    }
    return light;
}

Surface surfaceSeen(MaterialPoint m) {
    vec3 toEye = towardsEye();
    vec3 position = positionEye;
    vec3 face = cross(dFdx(position), dFdy(position));
    float across = dot(face, toEye);
    float least = leastCosineOver(across * across / max(dot(face, face), 1e-30f));
    Surface s = surfaceOf(m, toEye, least);
    if (viewHas(VIEW_SURFACE_LIGHT)) {
        SurfaceLight light =
            SurfaceLight(lightIrradiance, lightTurned, lightVisible, lightNearby, lightSides,
                         viewHas(VIEW_EMITTERS) ? lightEmitted : vec3(0.0f),
                         viewHas(VIEW_EMITTERS) ? lightEmittedFlux : vec3(0.0f), vec3(0.0f));
        s.light = lightOnSide(light, gl_FrontFacing, s.normal);
    }
    return s;
}

vec3 shaded(inout MaterialPoint m) {
    Surface s = surfaceSeen(m);
    if (layered(LAYER_CLEARCOAT)) m.emitted *= s.belowClearcoat;
    if (has(FEATURE_GLASS | FEATURE_TRACED_GLASS)) return shadedGlass(m, s);
    vec3 mirrored = reflectedRadiance(s, positionEye);
    // Light at vertices contains the occlusion already.
    float occlusion = viewHas(VIEW_SURFACE_LIGHT) ? 1.0f : m.occlusion;
    // Pictures and rays contain the occlusion that an occlusion texture approximates.
    const uint kLooked = FEATURE_MIRROR | FEATURE_PROBE | FEATURE_TRACED_REFLECTION;
    vec3 punctual = punctualLightAt(s);
    float pictured = picturedShare(s);
    if (pictured < 1.0f) {
        punctual += (1.0f - pictured) * emittersLight(s);
        if (has(kLooked)) mirrored = mix(harmonicsInLobe(s), mirrored, pictured);
    }
    if (layered(LAYER_SHEEN | LAYER_CLEARCOAT)) {
        return punctual + layeredLight(s, mirrored, has(kLooked) ? 1.0f : occlusion, occlusion);
    }
    weighRays(pictured * s.reflectance, vec3(0.0f));
    return punctual + s.reflectance * mirrored * (has(kLooked) ? 1.0f : occlusion) +
           occlusion * diffuseLight(s);
}

void main() {
    vec4 base = baseColorAt();
    if (has(FEATURE_MASK) && base.a < material.emissive.w) discard;
    float coverage = has(FEATURE_BLEND) ? clamp(base.a, 0.0f, 1.0f) : 1.0f;

    MaterialPoint m = materialAt(base);
    vec3 radiance;
    if (layered(LAYER_SHADOW_CATCHER)) {
        vec4 caught =
            caughtLight(surfaceSeen(m), positionEye, viewHas(VIEW_SUN_ONLY) ? 0 : int(drawNumbers.x),
                        viewHas(VIEW_SUN_ONLY) ? 1 : int(drawNumbers.y));
        radiance = caught.rgb;
        coverage = caught.a;
    } else {
        radiance = (has(FEATURE_UNLIT) ? base.rgb : shaded(m)) * coverage + finishRays(coverage);
    }
    // Coverage dims the reflected light, not the emission.
    float alpha = has(FEATURE_BLEND)         ? coverage
                  : viewHas(VIEW_COVERAGE) ? 1.0f
                                           : distanceShare(length(positionEye), view.picture.w);
    color = vec4(radianceFinite(radiance + m.emitted), alpha);
    if (has(FEATURE_BLEND) && has(FEATURE_BACKDROP)) {
        // Coverage applies to the whole surface, transmitted light included; the rest of the pixel
        // shows the backdrop.
        vec4 behind = texelFetch(backdrop, ivec2(gl_FragCoord.xy), 0);
        color.rgb += (1.0f - coverage) * behind.rgb;
        color.a = coverage < 0.5f ? shareStored(behind.a) : distanceShare(length(positionEye), view.picture.w);
    }
}
