// The picture with a share of its bright part taken away and the same light put back, spread out:
// what is lost here is found around (erratum E3).
#include "include/filter_source.glsl"
#include "include/glow.glsl"

layout(binding = UNIT_SPREAD) uniform sampler2D spread;  // at half the size

out vec4 color;

void main() {
    vec3 radiance = texelAt(source, ivec2(gl_FragCoord.xy));
    vec3 moved = between(spread, 0.5f * gl_FragCoord.xy) -
                 brightPart(radiance, filtering.parameters.x);
    // Spread light covers nothing: alpha stays.
    float alpha = pixelAt(source, ivec2(gl_FragCoord.xy)).a;
    color = vec4(radianceFinite(radiance + filtering.parameters.y * moved), alpha);
}
