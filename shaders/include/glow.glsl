// What of a pixel's light a glow spreads: what its brightest channel has above the threshold, in
// the pixel's own hue, so that nothing jumps at the threshold.
#ifndef CLERESTORY_GLOW_GLSL
#define CLERESTORY_GLOW_GLSL

vec3 brightPart(vec3 radiance, float threshold) {
    float most = maxComponent(radiance);
    return radiance * (max(most - threshold, 0.0f) / max(most, 1e-9f));
}

#endif
