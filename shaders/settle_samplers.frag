// Gives every sampler slot one state, before a pass draws. Mesa leaves the slot of a buffer texture with
// the state that an earlier program had there, llvmpipe compiles a variant for each state, and the
// second variant of a program may round differently: equal requests would not give equal bytes.
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
    ivec2 at = ivec2(gl_FragCoord.xy);
    color = texelFetch(s0, at, 0) + texelFetch(s1, at, 0) + texelFetch(s2, at, 0) + texelFetch(s3, at, 0) +
            texelFetch(s4, at, 0) + texelFetch(s5, at, 0) + texelFetch(s6, at, 0) + texelFetch(s7, at, 0) +
            texelFetch(s8, at, 0) + texelFetch(s9, at, 0) + texelFetch(s10, at, 0) + texelFetch(s11, at, 0) +
            texelFetch(s12, at, 0) + texelFetch(s13, at, 0) + texelFetch(s14, at, 0) + texelFetch(s15, at, 0);
}
