// Rays and their cones: what paths through the scene and the pixels that they start from share. Compiled
// as GLSL and as C++ (renderer/rays/shader_code.h).
#ifndef CLERESTORY_RAY_GLSL
#define CLERESTORY_RAY_GLSL

#include "include/material_point.glsl"

// Directions in eye space's axes and in the world's.
vec3 worldAxes(vec3 v) {
    return vec3(dot(view.worldFromEye[0].xyz, v), dot(view.worldFromEye[1].xyz, v),
                dot(view.worldFromEye[2].xyz, v));
}
vec3 eyeAxes(vec3 v) {
    return view.worldFromEye[0].xyz * v.x + view.worldFromEye[1].xyz * v.y +
           view.worldFromEye[2].xyz * v.z;
}

// Slopes of the cone that a ray represents: that of its pixel chooses levels of textures, that of
// rough surfaces those of the environment, too.
struct RayCone {
    float width;  // metres, where the ray starts
    float pixel;  // negative: it narrows towards a focus
    float lobe;
};

// The cone after some metres. Behind its focus it widens. Rays at the rim of a lens do not meet in its
// focus, so that a cone keeps this fraction of its width.
const float kFocus = 0.3f;
RayCone coneAfter(RayCone cone, float metres) {
    float width = cone.width + cone.pixel * metres;
    if (width < 0.0f) cone.pixel = -cone.pixel;
    cone.width = max(abs(width), kFocus * cone.width) + cone.lobe * metres;
    return cone;
}

// The slope of a pixel's cone behind a face, for light close to the face's normal. curvature: of the
// face, 1 / metres, above 0 where it bulges towards the ray; eta: index behind it over that before it.
float slopeBehind(RayCone cone, float curvature, float eta) {
    return cone.pixel / eta - (1.0f - 1.0f / eta) * curvature * cone.width;
}

// Away from the face that a ray leaves from, on the side of `normal`. Corners and sums of them are
// off by some 2^-22 of their greatest coordinate.
vec3 offsetRayOrigin(vec3 position, vec3 normal, float reach) {
    return position + worldAxes(normal) * (2e-6f * reach + 1e-30f);
}

// The mirrored direction of a bumpy or smoothed normal may point into the face itself: then it is
// laid along it.
vec3 mirroredAt(vec3 along, vec3 normal, vec3 faceNormal) {
    vec3 mirrored = reflect(along, normal);
    float above = dot(mirrored, faceNormal);
    return direction(mirrored + faceNormal * max(1e-3f - above, 0.0f));
}

#endif
