// One face of one roughness level of a prefiltered environment map: the GGX lobe seen from its own
// normal, summed over directions that C++ chose (the same for every texel but for the frame), each
// read at the level whose texels are as large as the share of the lobe it represents
// (Colbert and Krivanek, GPU Gems 3, chapter 20).
#include "include/block_macros.glsl"
#include "include/optics.glsl"
#include "include/sampling.glsl"

layout(binding = UNIT_SOURCE) uniform samplerCube source;

out vec4 color;

void main() {
    vec2 st = gl_FragCoord.xy * prefilter.faceAxes[0].w - 1.0f;  // -1..1 over the face
    vec3 n = normalize(prefilter.faceAxes[0].xyz + st.x * prefilter.faceAxes[1].xyz +
                       st.y * prefilter.faceAxes[2].xyz);  // length 1 to sqrt(3) before
    mat3 mapFromLobe = frameAbout(n);

    vec4 sum = vec4(0.0f);  // a captured cube keeps distances in alpha
    float weight = 0.0f;
    int i = 0;
    do {
        vec4 s = prefilter.samples[i];
        sum += textureLod(source, mapFromLobe * s.xyz, s.w) * s.z;
        weight += s.z;
    } while (++i < prefilter.counts.x);
    sum /= max(weight, 1e-6f);
    color = vec4(radianceFinite(sum.rgb), sum.a);
}
