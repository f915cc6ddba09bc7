// The far end of depth, behind everything.
#include "include/block_macros.glsl"

out vec3 towards;  // not normalised; linear over the picture

void main() {
    vec2 corner = vec2(float((gl_VertexID & 1) * 4 - 1), float((gl_VertexID >> 1) * 4 - 1));
    towards = view.skyDirections[0].xyz + corner.x * view.skyDirections[1].xyz +
              corner.y * view.skyDirections[2].xyz;
    gl_Position = vec4(corner, view.environment.z, 1.0f);
}
