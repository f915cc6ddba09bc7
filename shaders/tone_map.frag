// Linear radiance to display colour, turned so that the first row is the top one. The target
// encodes sRGB. VARIANT is the curve.
#include "include/block_macros.glsl"
#include "include/optics.glsl"
#include "include/tonemap.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

vec3 mapped(vec3 radiance) {
    int curve = VARIANT & ~TONE_MAP_TRANSPARENT;
    if (curve == TONE_MAP_NEUTRAL) return toneMapNeutral(radiance);
    if (curve == TONE_MAP_ACES) return toneMapAces(radiance);
    return toneMapLinear(radiance);
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    texel.y = textureSize(source, 0).y - 1 - texel.y;
    vec4 pixel = texelFetch(source, texel, 0);
    vec3 radiance = pixel.rgb * filtering.parameters.x;
    vec3 display = mapped(radiance);
    if ((VARIANT & TONE_MAP_TRANSPARENT) != 0) {
        // Light that is brighter than the alpha of its pixel can show is kept by a greater alpha.
        float alpha = max(clamp(pixel.a, 0.0f, 1.0f), max(display.r, max(display.g, display.b)));
        color = vec4(alpha > 0.0f ? alpha * mapped(radiance / alpha) : vec3(0.0f), alpha);
        return;
    }
    // Approximate perceived brightness, for the edge filter; the output picture is opaque.
    color = vec4(display, mix(1.0f, sqrt(luminance(display)), filtering.parameters.y));
}
