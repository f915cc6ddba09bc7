// A picture at half its size, rounded up: each texel is a sum of 4 by 4 with weights 1 3 3 1, which
// equals the sum of four bilinear reads between texels. Every source texel has the same total weight.
#include "include/filter_source.glsl"

out vec4 color;

void main() {
    // Between the outer texel and its inner neighbour, three times as near to that.
    vec2 at = 2.0f * gl_FragCoord.xy;
    vec3 sum = between(source, at + vec2(-0.75f, -0.75f)) +
               between(source, at + vec2(0.75f, -0.75f)) +
               between(source, at + vec2(-0.75f, 0.75f)) +
               between(source, at + vec2(0.75f, 0.75f));
    color = vec4(radianceFinite(0.25f * sum), 1.0f);
}
