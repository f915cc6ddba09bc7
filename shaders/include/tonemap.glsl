// From linear radiance to what a display shows. Needs optics.glsl before it (radianceFinite).
// Every curve takes any input, also NaN and infinity, and returns linear display light in 0..1.
#ifndef CLERESTORY_TONEMAP_GLSL
#define CLERESTORY_TONEMAP_GLSL

vec3 toneMapLinear(vec3 radiance) {
    return min(radianceFinite(radiance), vec3(1.0f));
}

// Khronos PBR Neutral (2024): true colours up to 0.8, then highlights roll off towards white.
// Below that only the 0.04 that a dielectric's surface reflects is taken away again.
vec3 toneMapNeutral(vec3 radiance) {
    const float kStart = 0.76f;  // 0.8 - 0.04
    const float kDesaturation = 0.15f;
    vec3 c = radianceFinite(radiance);
    float low = min(c.x, min(c.y, c.z));
    float offset = low < 0.08f ? low - 6.25f * low * low : 0.04f;
    c = c - offset;
    float peak = max(c.x, max(c.y, c.z));
    if (peak < kStart) {
        return max(c, vec3(0.0f));
    }
    float room = 1.0f - kStart;
    float newPeak = 1.0f - room * room / (peak + room - kStart);
    c = c * (newPeak / peak);
    float white = 1.0f - 1.0f / (kDesaturation * (peak - newPeak) + 1.0f);
    return clamp(mix(c, vec3(newPeak), white), 0.0f, 1.0f);
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
                 0.0f, 1.0f);
}

// IEC 61966-2-1, both ways; the argument is clamped to 0..1.
float srgbFromLinear(float linearValue) {
    float x = min(radianceFinite(linearValue), 1.0f);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}
vec3 srgbFromLinear(vec3 c) {
    return vec3(srgbFromLinear(c.x), srgbFromLinear(c.y), srgbFromLinear(c.z));
}
float linearFromSrgb(float srgbValue) {
    float x = min(radianceFinite(srgbValue), 1.0f);
    return x <= 0.04045f ? x / 12.92f : pow((x + 0.055f) / 1.055f, 2.4f);
}
vec3 linearFromSrgb(vec3 c) {
    return vec3(linearFromSrgb(c.x), linearFromSrgb(c.y), linearFromSrgb(c.z));
}

#endif
