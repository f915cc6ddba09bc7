// A pixel of a surface: its material, the light on it, the light it gives off.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/material.glsl"
#include "include/lighting.glsl"
#include "include/reflection.glsl"

out vec4 color;  // premultiplied by coverage

vec3 towardsEye() {
    return direction(mix(-positionEye, -view.forward.xyz, view.forward.w));
}

vec3 shaded(MaterialPoint m) {
    Surface s = surfaceOf(m, towardsEye());
    vec3 lamps = vec3(0.0f);
    if (has(FEATURE_LIGHTS)) {
        lamps = lampsLight(s, positionEye, int(drawNumbers.x), int(drawNumbers.y));
    }
    return lamps + m.occlusion * surroundingLight(s, reflectedRadiance(s, positionEye));
}

void main() {
    vec4 base = baseColorAt();
    if (has(FEATURE_MASK) && base.a < material.emissive.w) discard;
    float coverage = has(FEATURE_BLEND) ? clamp(base.a, 0.0f, 1.0f) : 1.0f;

    MaterialPoint m = materialAt(base);
    vec3 radiance = has(FEATURE_UNLIT) ? base.rgb : shaded(m);
    // Coverage dims what lies on the surface, not what it gives off.
    color = vec4(radianceFinite(radiance * coverage + m.emitted), coverage);
}
