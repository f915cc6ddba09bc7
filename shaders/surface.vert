// A vertex of the scene, for shading and for channels. The same for every variant but for those with
// VIEW_SURFACE_LIGHT: the linker removes the outputs that a variant does not read, and what they are
// computed from.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#include "include/eye_position.glsl"
#include "include/surface_light.glsl"
#include "include/surface_light_sampler.glsl"
#define VARYING out
#include "include/surface_varyings.glsl"

layout(location = ATTRIBUTE_NORMAL) in vec3 normal;
layout(location = ATTRIBUTE_TANGENT) in vec4 tangent;
layout(location = ATTRIBUTE_TEXCOORD0) in vec2 inTexCoord0;
layout(location = ATTRIBUTE_TEXCOORD1) in vec2 inTexCoord1;
layout(location = ATTRIBUTE_COLOR) in vec4 inColor;
layout(location = ATTRIBUTE_NORMAL_FROM_MODEL) in vec4 normalFromModel[3];  // rows; w: drawNumbers

// Scaled first: a tiny instance's squares would underflow.
vec3 unit(vec3 v) {
    vec3 scaled = v / max(max(abs(v.x), max(abs(v.y), abs(v.z))), 1e-30f);
    return scaled * inversesqrt(max(dot(scaled, scaled), 1e-20f));
}

void main() {
    positionEye = eyePosition();
    gl_Position = clipPosition(positionEye);
    clipAt(positionEye);

    vertexNormal = unit(vec3(dot(normalFromModel[0].xyz, normal), dot(normalFromModel[1].xyz, normal),
                             dot(normalFromModel[2].xyz, normal)));
    float volume = dot(eyeFromModel[0].xyz, cross(eyeFromModel[1].xyz, eyeFromModel[2].xyz));
    modelScale = pow(max(abs(volume), 1e-36f), 1.0f / 3.0f);
    drawNumbers = vec3(normalFromModel[0].w, normalFromModel[1].w, normalFromModel[2].w);
    vertexTangent.xyz =
        unit(vec3(dot(eyeFromModel[0].xyz, tangent.xyz), dot(eyeFromModel[1].xyz, tangent.xyz),
                  dot(eyeFromModel[2].xyz, tangent.xyz)));
    // A mirrored instance turns the cross product of normal and tangent round.
    vertexTangent.w = volume < 0.0f ? -tangent.w : tangent.w;
    if (viewHas(VIEW_SURFACE_LIGHT)) {
        int value = surfaceLightValue(normalFromModel[2].w, gl_VertexID);
        SurfaceLight light = surfaceLightOf(surfaceLightRow(value, 0), surfaceLightRow(value, 1));
        lightIrradiance = light.irradiance;
        lightTurned = light.turned;
        lightVisible = light.visible;
        lightNearby = light.nearby;
        lightSides = light.sides;
        if (viewHas(VIEW_EMITTERS)) {
            light = withEmitters(light, surfaceLightRow(value, SURFACE_LIGHT_ROWS));
            lightEmitted = light.emitted;
            lightEmittedFlux = light.emittedFlux;
        }
    }
    texCoord0 = inTexCoord0;
    texCoord1 = inTexCoord1;
    vertexColor = inColor;
}
