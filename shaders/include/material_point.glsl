// A material at a point of a surface, and directions.
#ifndef CLERESTORY_MATERIAL_POINT_GLSL
#define CLERESTORY_MATERIAL_POINT_GLSL

// What a material says about a point of a surface, however the point was reached.
struct MaterialPoint {
    vec4 baseColor;  // w: coverage
    float metallic;
    float roughness;
    vec3 dielectricF0;  // at normal incidence, of the dielectric part; scaled by `specular`
    float specular;     // of the dielectric lobe at every angle (KHR_materials_specular)
    float grazing;      // what that lobe reflects edge-on
    vec3 normal;        // unit, bumps included, on the side that is seen
    float occlusion;    // of indirect light
    vec3 emitted;       // added after everything else and scaled by nothing else
};

// Squared lengths below this are no direction.
const float kNoDirection = 1e-20f;
vec3 direction(vec3 v) {
    return v * inversesqrt(max(dot(v, v), kNoDirection));
}

// Of a texel of TextureImage::packedNormal: unit, in tangent space.
vec3 unpackedNormal(vec4 texel) {
    vec2 slope = texel.ra * 2.0f - 1.0f;
    return vec3(slope, sqrt(max(1.0f - dot(slope, slope), 0.0f)));
}

#endif
