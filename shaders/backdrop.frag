// A picture as the background of rough glass.
#include "include/bindings.glsl"
#include "include/distance_share.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

void main() {
    color = texelFetch(source, ivec2(gl_FragCoord.xy), 0);
    color.a = asInverse(color.a);
}
