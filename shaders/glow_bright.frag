// The bright part of a picture at half its size: as glow_down.frag, but each texel is first split
// into what spreads and what stays.
#include "include/filter_source.glsl"
#include "include/glow.glsl"

out vec4 color;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy) - 1;
    vec3 sum = vec3(0.0f);
    int i = 0;
    do {
        ivec2 step = ivec2(i & 3, i >> 2);
        vec2 weight = vec2((step.x == 1 || step.x == 2) ? 0.375f : 0.125f,
                           (step.y == 1 || step.y == 2) ? 0.375f : 0.125f);
        sum += weight.x * weight.y * brightPart(texelAt(source, first + step), filtering.parameters.x);
    } while (++i < 16);
    color = vec4(radianceFinite(sum), 1.0f);
}
