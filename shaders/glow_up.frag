// A picture at twice its size, blended over the target with weight `share`.
#include "include/filter_source.glsl"

out vec4 color;

void main() {
    float share = filtering.parameters.x;
    color = vec4(share * radianceFinite(between(source, 0.5f * gl_FragCoord.xy)), share);
}
