// Depth alone: positions and nothing else.
#include "include/block_macros.glsl"
#include "include/eye_position.glsl"

void main() {
    gl_Position = clipPosition(eyePosition());
}
