// Depth alone: positions and nothing else.
#include "include/block_macros.glsl"
#include "include/eye_position.glsl"

void main() {
    vec3 positionEye = eyePosition();
    gl_Position = clipPosition(positionEye);
    clipAt(positionEye);
}
