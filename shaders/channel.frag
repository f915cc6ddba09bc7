// A number instead of a colour. VARIANT says which: metres along the view direction, the world
// normal of the geometry (no normal map), the draw's own number; or, for glass, the outward normal of a
// back face and how far away it is.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/material.glsl"
#include "include/distance_share.glsl"

out vec4 number;

void main() {
    if (has(FEATURE_MASK) && baseColorAt().a < material.emissive.w) discard;
    number = vec4(0.0f);
    if (VARIANT == CHANNEL_DEPTH) number.x = dot(view.forward.xyz, positionEye);
    if (VARIANT == CHANNEL_NORMAL) number.xyz = normalAt();
    if (VARIANT == CHANNEL_NUMBER) number.x = drawNumbers.z;
    if (VARIANT == CHANNEL_BACK_FACES) {
        number = vec4(direction(vertexNormal), distanceShare(length(positionEye), view.picture.w));
    }
}
