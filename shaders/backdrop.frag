// A picture as the background of rough glass. VARIANT: SAMPLED_PIXELS.
#include "include/bindings.glsl"
#include "include/distance_share.glsl"
#include "include/sampled_pixels.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

void main() {
    if ((VARIANT & SAMPLED_PIXELS) != 0 && !isSampled()) discard;
    color = texelFetch(source, ivec2(gl_FragCoord.xy), 0);
    color.a = asInverse(color.a);
}
