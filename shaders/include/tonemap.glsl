// Tone mapping: from linear radiance to display light. Needs optics.glsl before it (radianceFinite).
// Every curve takes any input, also NaN and infinity, and returns linear display light in 0..1.
// Without branches: renderer/display compiles them for several pixels at a time.
#ifndef CLERESTORY_TONEMAP_GLSL
#define CLERESTORY_TONEMAP_GLSL

vec3 toneMapLinear(vec3 radiance) {
    return min(radianceFinite(radiance), vec3(1.0f));
}

// Khronos PBR Neutral (2024): colours are unchanged up to 0.8, then highlights roll off towards white.
// Below that only the 0.04 that a dielectric's surface reflects is subtracted.
vec3 toneMapNeutral(vec3 radiance) {
    const float kStart = 0.76f;  // 0.8 - 0.04
    const float kDesaturation = 0.15f;
    vec3 c = radianceFinite(radiance);
    float low = min(min(c.x, min(c.y, c.z)), 0.08f);
    c = c - (low - 6.25f * low * low);  // from 0.08 on: 0.04
    // At the start of the roll-off the curve is the identity, so that darker colours need no case.
    float peak = max(max(c.x, max(c.y, c.z)), kStart);
    float room = 1.0f - kStart;
    float newPeak = 1.0f - room * room / (peak + room - kStart);
    float white = 1.0f - 1.0f / (kDesaturation * (peak - newPeak) + 1.0f);
    c = c * (newPeak / peak);
    return clamp(mix(c, vec3(newPeak), white), vec3(0.0f), vec3(1.0f));
}

// Stephen Hill's fit of the ACES reference rendering and sRGB output transforms: into a wider
// space, a rational curve, and back.
vec3 toneMapAces(vec3 radiance) {
    vec3 c = radianceFinite(radiance);
    vec3 a = vec3(dot(vec3(0.59719f, 0.35458f, 0.04823f), c),
                  dot(vec3(0.07600f, 0.90834f, 0.01566f), c),
                  dot(vec3(0.02840f, 0.13383f, 0.83777f), c));
    vec3 b = (a * (a + 0.0245786f) - 0.000090537f) /
             (a * (0.983729f * a + 0.4329510f) + 0.238081f);
    return clamp(vec3(dot(vec3(1.60475f, -0.53108f, -0.07367f), b),
                      dot(vec3(-0.10208f, 1.10813f, -0.00605f), b),
                      dot(vec3(-0.00327f, -0.07276f, 1.07602f), b)),
                 vec3(0.0f), vec3(1.0f));
}

#endif
