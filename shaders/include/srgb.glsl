// Between linear light and the code of a display. Needs optics.glsl before it (radianceFinite).
#ifndef CLERESTORY_SRGB_GLSL
#define CLERESTORY_SRGB_GLSL

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
