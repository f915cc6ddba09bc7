// A picture before a black background, with alpha: the difference to the picture before a white one of
// radiance 1 is the transmittance of its pixels.
#include "include/block_macros.glsl"
#include "include/optics.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;
layout(binding = UNIT_SPREAD) uniform sampler2D white;

out vec4 color;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec3 black = texelFetch(source, texel, 0).rgb;
    vec3 through = clamp(texelFetch(white, texel, 0).rgb - black, 0.0f, 1.0f);
    color = vec4(radianceFinite(black), 1.0f - (through.r + through.g + through.b) / 3.0f);
}
