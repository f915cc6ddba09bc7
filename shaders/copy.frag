// A picture, texel by texel.
#include "include/bindings.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

void main() {
    color = texelFetch(source, ivec2(gl_FragCoord.xy), 0);
}
