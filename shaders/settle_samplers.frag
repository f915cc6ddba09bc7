// Gives every sampler slot one state before a pass draws. Mesa leaves the slot of a buffer texture with
// the state that an earlier program set there, llvmpipe compiles a variant for each state, and the
// second variant of a program may round differently: equal requests would not give equal bytes.
//
// No pixel is shaded; see settle_samplers.vert. Sizes are read instead of texels because the driver
// compiles them in a tenth of the time.
#include "include/bindings.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D s0;
layout(binding = UNIT_SOURCE) uniform sampler2D s1;
layout(binding = UNIT_SOURCE) uniform sampler2D s2;
layout(binding = UNIT_SOURCE) uniform sampler2D s3;
layout(binding = UNIT_SOURCE) uniform sampler2D s4;
layout(binding = UNIT_SOURCE) uniform sampler2D s5;
layout(binding = UNIT_SOURCE) uniform sampler2D s6;
layout(binding = UNIT_SOURCE) uniform sampler2D s7;
layout(binding = UNIT_SOURCE) uniform sampler2D s8;
layout(binding = UNIT_SOURCE) uniform sampler2D s9;
layout(binding = UNIT_SOURCE) uniform sampler2D s10;
layout(binding = UNIT_SOURCE) uniform sampler2D s11;
layout(binding = UNIT_SOURCE) uniform sampler2D s12;
layout(binding = UNIT_SOURCE) uniform sampler2D s13;
layout(binding = UNIT_SOURCE) uniform sampler2D s14;
layout(binding = UNIT_SOURCE) uniform sampler2D s15;

out vec4 color;

void main() {
    ivec2 size = textureSize(s0, 0) + textureSize(s1, 0) + textureSize(s2, 0) + textureSize(s3, 0) +
                 textureSize(s4, 0) + textureSize(s5, 0) + textureSize(s6, 0) + textureSize(s7, 0) +
                 textureSize(s8, 0) + textureSize(s9, 0) + textureSize(s10, 0) + textureSize(s11, 0) +
                 textureSize(s12, 0) + textureSize(s13, 0) + textureSize(s14, 0) + textureSize(s15, 0);
    color = vec4(size, size);
}
