// One sample of each pixel of records of rays; its number is filtering.parameters.x.
#include "include/block_macros.glsl"

layout(binding = UNIT_SOURCE) uniform usampler2DMS source;

out uvec4 record;

void main() {
    record = texelFetch(source, ivec2(gl_FragCoord.xy), int(filtering.parameters.x));
}
