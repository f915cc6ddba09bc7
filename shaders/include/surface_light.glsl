// Light at a point of a surface from its surroundings, as it was computed at vertices
// (renderer/light/surface_light.h). Directions have the axes of eye space. Compiled as GLSL and as
// C++ (renderer/rays/shader_code.h).
#ifndef CLERESTORY_SURFACE_LIGHT_GLSL
#define CLERESTORY_SURFACE_LIGHT_GLSL

struct SurfaceLight {
    vec3 irradiance;  // over pi
    vec4 turned;      // factor of it for another normal
    vec4 visible;     // share of the environment from a direction; see gatheredFrom()
    vec3 nearby;      // mean radiance of what hides the environment
    vec2 sides;       // of a two-sided surface; see lightOnSide()
    // If VIEW_EMITTERS, of emissive surfaces: the integral of the radiance over directions, over pi,
    // and that of luminance times direction.
    vec3 emitted;
    vec3 emittedFlux;
    vec3 behind;  // `irradiance` of the other side of the surface; see lightOnSide()
};

// The value of a vertex of an instance whose values begin at `first`. With a half added it is that of
// all vertices.
int surfaceLightValue(float first, int vertex) {
    float whole = floor(first);
    return int(whole) + (first > whole ? 0 : vertex);
}

SurfaceLight surfaceLightOf(uvec4 first, uvec4 second) {
    SurfaceLight light;
    vec2 a = unpackHalf2x16(first.x);
    vec2 b = unpackHalf2x16(first.y);
    vec2 c = unpackHalf2x16(first.z);
    vec2 d = unpackHalf2x16(first.w);
    vec2 e = unpackHalf2x16(second.x);
    vec2 f = unpackHalf2x16(second.y);
    vec2 g = unpackHalf2x16(second.z);
    light.sides = unpackHalf2x16(second.w);
    light.irradiance = vec3(a.x, a.y, b.x);
    light.behind = vec3(0.0f);
    light.nearby = vec3(b.y, c.x, c.y);
    light.visible = vec4(f.y, g.x, g.y, d.x);
    light.turned = vec4(e.x, e.y, f.x, d.y);
    light.emitted = vec3(0.0f);
    light.emittedFlux = vec3(0.0f);
    return light;
}

SurfaceLight withEmitters(SurfaceLight light, uvec4 emitters) {
    vec2 a = unpackHalf2x16(emitters.x);
    vec2 b = unpackHalf2x16(emitters.y);
    vec2 c = unpackHalf2x16(emitters.z);
    light.emitted = vec3(a.x, a.y, b.x);
    light.emittedFlux = vec3(b.y, c.x, c.y);
    return light;
}

// As kOfSides in renderer/light/surface_light.h.
const float kLightOfSides = 4.0f;

// A two-sided surface has the light of both sides in one value (ofBothSides()). normal: of the side.
SurfaceLight lightOnSide(SurfaceLight light, bool front, vec3 normal) {
    light.behind = light.irradiance * clamp(light.turned.w - dot(light.turned.xyz, normal), 0.0f, 4.0f);
    if (light.visible.w > 0.5f * kLightOfSides) {
        light.behind = front ? light.turned.xyz : light.irradiance;
        vec3 slope = light.visible.xyz;
        slope -= front ? vec3(0.0f) : 2.0f * dot(slope, normal) * normal;
        light.visible = vec4((front ? light.sides.x : light.sides.y) * slope,
                             front ? light.visible.w - kLightOfSides : light.turned.w);
        light.irradiance = front ? light.irradiance : light.turned.xyz;
        light.turned = vec4(0.0f, 0.0f, 0.0f, 1.0f);
        light.nearby *= dot(light.irradiance, vec3(0.2126f, 0.7152f, 0.0722f));  // luminance
    }
    return light;
}

vec3 diffuseFrom(SurfaceLight light, vec3 normal) {
    float factor = clamp(dot(light.turned.xyz, normal) + light.turned.w, 0.0f, 4.0f);
    return light.irradiance * factor;
}

// environment: what the lobe about `towards` would gather if nothing hid it.
vec3 gatheredFrom(SurfaceLight light, vec3 towards, vec3 environment) {
    float share = clamp(dot(light.visible.xyz, towards) + light.visible.w, 0.0f, 1.0f);
    return environment * share + light.nearby * (1.0f - share);
}

#endif
