// A number instead of a colour. VARIANT says which: metres along the view direction, the world
// normal of the geometry (no normal map), the world position, the base colour, the draw's own number,
// alone or with that of its primitive; or, for glass, the outward normal of a back face and how far
// away it is.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/material.glsl"
#include "include/distance_share.glsl"

out vec4 number;

vec3 worldPosition() {
    vec3 eye = vec3(view.worldFromEye[0].w, view.worldFromEye[1].w, view.worldFromEye[2].w);
    return eye + positionEye;  // channels keep the world's axes
}

void main() {
    if (has(FEATURE_MASK) && baseColorAt().a < material.emissive.w) discard;
    number = vec4(0.0f);
    if (VARIANT == CHANNEL_DEPTH) number.x = dot(view.forward.xyz, positionEye);
    if (VARIANT == CHANNEL_NORMAL) number.xyz = normalAt();
    if (VARIANT == CHANNEL_NUMBER) number.x = drawNumbers.z;
    if (VARIANT == CHANNEL_SURFACE) number.xy = vec2(drawNumbers.z, gl_PrimitiveID);
    if (VARIANT == CHANNEL_POSITION) number.xyz = worldPosition();
    if (VARIANT == CHANNEL_ALBEDO) number.xyz = baseColorAt().rgb;
    if (VARIANT == CHANNEL_BACK_FACES) {
        number = vec4(direction(vertexNormal), distanceShare(length(positionEye), view.picture.w));
    }
}
