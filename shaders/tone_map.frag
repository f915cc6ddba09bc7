// Linear radiance to display colour, turned so that the first row is the top one. The target
// encodes sRGB. VARIANT is the curve.
#include "include/block_macros.glsl"
#include "include/optics.glsl"
#include "include/tonemap.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    texel.y = textureSize(source, 0).y - 1 - texel.y;
    vec3 radiance = texelFetch(source, texel, 0).rgb * filtering.parameters.x;
    vec3 display = radiance;
    if (VARIANT == TONE_MAP_NEUTRAL) display = toneMapNeutral(radiance);
    if (VARIANT == TONE_MAP_ACES) display = toneMapAces(radiance);
    if (VARIANT == TONE_MAP_LINEAR) display = toneMapLinear(radiance);
    // Brightness about as it is seen, for the edge filter; a picture that goes out is opaque.
    color = vec4(display, mix(1.0f, sqrt(luminance(display)), filtering.parameters.y));
}
