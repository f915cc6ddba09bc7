// One face of a cube, blurred about one of the cube's axes: the weighted mean over rotations about it.
// Three passes, one for each axis, blur all directions isotropically, since the squared displacements
// of the three rotations add up to the same in every direction. In the middle of a face two of them
// are its rows and columns. Rotations are independent of faces, so there is no seam, and they preserve
// areas, so the sum of the light is unchanged.
#include "include/block_macros.glsl"
#include "include/optics.glsl"

layout(binding = UNIT_SOURCE) uniform samplerCube source;

out vec4 color;

void main() {
    vec2 st = gl_FragCoord.xy * prefilter.faceAxes[0].w - 1.0f;  // -1..1 over the face
    vec3 direction = prefilter.faceAxes[0].xyz + st.x * prefilter.faceAxes[1].xyz +
                     st.y * prefilter.faceAxes[2].xyz;
    vec3 axis = vec3(prefilter.counts.y == 0, prefilter.counts.y == 1, prefilter.counts.y == 2);
    vec3 across = cross(axis, direction);
    vec3 along = dot(axis, direction) * axis;
    vec4 sum = vec4(0.0f);  // a captured cube keeps distances in alpha
    int i = 0;
    do {
        vec4 turn = prefilter.samples[i];
        sum += turn.z * textureLod(source, along + turn.x * (direction - along) + turn.y * across, 0.0f);
    } while (++i < prefilter.counts.x);
    color = vec4(radianceFinite(sum.rgb), sum.a);
}
