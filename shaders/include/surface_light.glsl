// Light at a point of a surface from its surroundings, as it was computed at vertices
// (renderer/light/surface_light.h). Directions have the axes of eye space. Compiled as GLSL and as
// C++ (renderer/rays/path.cpp).
#ifndef CLERESTORY_SURFACE_LIGHT_GLSL
#define CLERESTORY_SURFACE_LIGHT_GLSL

struct SurfaceLight {
    vec3 irradiance;  // over pi
    vec4 turned;      // factor of it for another normal
    vec4 visible;     // share of the environment from a direction, or on a side; see gatheredFrom()
    vec3 nearby;      // mean radiance of what hides the environment
};

// The value of a vertex of an instance whose values begin at `first`. With a half added it is that of
// all vertices.
int surfaceLightValue(float first, int vertex) {
    float whole = floor(first);
    return int(whole) + (first > whole ? 0 : vertex);
}

SurfaceLight surfaceLightOf(uvec4 first, uvec4 second) {
    vec2 a = unpackHalf2x16(first.x);
    vec2 b = unpackHalf2x16(first.y);
    vec2 c = unpackHalf2x16(first.z);
    vec2 d = unpackHalf2x16(first.w);
    vec2 e = unpackHalf2x16(second.x);
    vec2 f = unpackHalf2x16(second.y);
    vec2 g = unpackHalf2x16(second.z);
    SurfaceLight light;
    light.irradiance = vec3(a.x, a.y, b.x);
    light.nearby = vec3(b.y, c.x, c.y);
    light.visible = vec4(f.y, g.x, g.y, d.x);
    light.turned = vec4(e.x, e.y, f.x, d.y);
    return light;
}

vec3 diffuseFrom(SurfaceLight light, vec3 normal) {
    float factor = clamp(dot(light.turned.xyz, normal) + light.turned.w, 0.0f, 4.0f);
    return light.irradiance * factor;
}

// As kOfSides in renderer/light/surface_light.h.
const float kLightOfSides = 4.0f;

// environment: what the lobe about `towards` would gather if nothing hid it. normal: on the side that
// is seen. What a thin wall sees of the environment on one side says nothing about the other one.
vec3 gatheredFrom(SurfaceLight light, vec3 normal, vec3 towards, vec3 environment) {
    bool ofSides = light.visible.w > 0.5f * kLightOfSides;
    vec3 at = ofSides ? normal : towards;
    float constant = light.visible.w - (ofSides ? kLightOfSides : 0.0f);
    float share = clamp(dot(light.visible.xyz, at) + constant, 0.0f, 1.0f);
    return environment * share + light.nearby * (1.0f - share);
}

#endif
