// A material at a pixel: its factors times its textures. Only values that FEATURES selects are fetched.

#include "include/material_point.glsl"

layout(binding = UNIT_BASE_COLOR) uniform sampler2D baseColorMap;
layout(binding = UNIT_METALLIC_ROUGHNESS) uniform sampler2D metallicRoughnessMap;
#if HAS_NORMAL_MAP  // a driver may count a sampler that no code reads
layout(binding = UNIT_NORMAL) uniform sampler2D normalMap;
#endif
layout(binding = UNIT_OCCLUSION) uniform sampler2D occlusionMap;
layout(binding = UNIT_EMISSIVE) uniform sampler2D emissiveMap;
layout(binding = UNIT_TRANSMISSION) uniform sampler2D transmissionMap;
layout(binding = UNIT_THICKNESS) uniform sampler2D thicknessMap;

vec2 texCoordBy(vec4 uRow, vec4 vRow) {
    vec2 uv = texCoord0;
    if (has(FEATURE_SECOND_TEXCOORD)) uv = uRow.w > 0.5f ? texCoord1 : texCoord0;
    if (has(FEATURE_TEXTURE_TRANSFORM)) {
        uv = vec2(dot(uRow.xyz, vec3(uv, 1.0f)), dot(vRow.xyz, vec3(uv, 1.0f)));
    }
    return uv;
}
vec2 texCoordOf(int slot) {
    return texCoordBy(material.texCoordRows[2 * slot], material.texCoordRows[2 * slot + 1]);
}
vec4 baseColorAt() {
    precise vec4 color = material.baseColor;  // the same in programs with more and fewer features
    if (has(FEATURE_BASE_COLOR_MAP)) color *= texture(baseColorMap, texCoordOf(UNIT_BASE_COLOR));
    // Interpolated, white is not always exactly 1.
    if (has(FEATURE_VERTEX_COLOR) && viewHas(VIEW_SHARED_PROGRAMS))
        color *= fract(drawNumbers.y) >= 0.5f ? vec4(1.0f) : vertexColor;
    else if (has(FEATURE_VERTEX_COLOR))
        color *= vertexColor;
    return color;
}

// Metallic, roughness, normal scale. Each number that is read out of a block costs a software
// rasteriser some thirty instructions for every eight pixels.
vec3 materialNumbers() {
    return has(FEATURE_DEFAULT_NUMBERS) ? vec3(1.0f) : material.surface.xyz;
}

vec4 mappedNormal() {
#if HAS_NORMAL_MAP
    return texture(normalMap, texCoordOf(UNIT_NORMAL));
#else
    return vec4(0.0f);
#endif
}

// Metallic, roughness.
vec2 metallicRoughnessAt() {
    precise vec2 metallicRoughness = materialNumbers().xy;
    if (has(FEATURE_METALLIC_ROUGHNESS_MAP)) {
        // Packed, it is the picture that the normal is read from: one fetch for both.
        metallicRoughness *=
            has(FEATURE_PACKED_NORMAL)
                ? mappedNormal().bg
                : texture(metallicRoughnessMap, texCoordOf(UNIT_METALLIC_ROUGHNESS)).bg;
    }
    return clamp(metallicRoughness, 0.0f, 1.0f);
}

vec3 turnedToEye(vec3 n) {
    return gl_FrontFacing ? n : -n;  // backs of one-sided surfaces are culled
}

// Of the texel of a normal map with this scale. n: the mesh's normal, not normalised before: as the tangents
// were made (mikktspace.com).
vec3 bumpedNormal(vec3 n, vec4 texel, bool isPacked, float scale) {
    vec3 t = vertexTangent.xyz;
    vec3 b = cross(n, t) * vertexTangent.w;
    vec3 bump = isPacked ? unpackedNormal(texel) : texel.xyz * 2.0f - 1.0f;
    bump.xy *= scale;
    return turnedToEye(direction(t * bump.x + b * bump.y + n * bump.z));
}

// x, y: the turn without bumps. here: the normal at uv. roughness: of the highlight; only for narrow
// ones the map is read, four times.
Turn turnIn(sampler2D map, vec2 uv, vec3 x, vec3 y, vec3 here, bool isPacked, float scale,
            float roughness) {
    vec2 u = dFdx(uv);
    vec2 v = dFdy(uv);
    // A finer level shows more edges, where the turn is not steady.
    vec2 du = 0.5f * u;
    vec2 dv = 0.5f * v;
    Turn turn = evenTurn(x, y);
    if (roughness < kGlintRoughness) {
        vec3 n = vertexNormal;
        turn = bumpyTurn(x, y, here, bumpedNormal(n, textureGrad(map, uv - u, du, dv), isPacked, scale),
                         bumpedNormal(n, textureGrad(map, uv + u, du, dv), isPacked, scale),
                         bumpedNormal(n, textureGrad(map, uv - v, du, dv), isPacked, scale),
                         bumpedNormal(n, textureGrad(map, uv + v, du, dv), isPacked, scale));
    }
    return turn;
}

vec3 normalAt() {
    vec3 n = vertexNormal;
    if (!has(FEATURE_NORMAL_MAP)) return turnedToEye(direction(n));
    return bumpedNormal(n, mappedNormal(), has(FEATURE_PACKED_NORMAL), materialNumbers().z);
}
// normal: normalAt().
Turn turnAt(vec3 x, vec3 y, vec3 normal, float roughness) {
#if HAS_NORMAL_MAP
    return turnIn(normalMap, texCoordOf(UNIT_NORMAL), x, y, normal, has(FEATURE_PACKED_NORMAL),
                  materialNumbers().z, roughness);
#else
    return evenTurn(x, y);
#endif
}

float occlusionAt() {
    float occlusion = 1.0f;
    if (has(FEATURE_OCCLUSION_MAP)) {
        float seen = texture(occlusionMap, texCoordOf(UNIT_OCCLUSION)).r;
        occlusion += material.surface.w * (seen - 1.0f);
    }
    return occlusion;
}

vec3 emittedAt() {
    if (!has(FEATURE_EMISSION)) return vec3(0.0f);
    precise vec3 emitted = material.emissive.rgb;
    if (has(FEATURE_EMISSIVE_MAP)) emitted *= texture(emissiveMap, texCoordOf(UNIT_EMISSIVE)).rgb;
    return emitted;
}

#if HAS_LAYERS
#include "include/material_layers.glsl"
#else
Layers layersAt(vec3 normal) {
    return noLayers();
}
Turn clearcoatTurnAt(vec3 x, vec3 y, Layers l) {
    return evenTurn(x, y);
}
void applySpecularMaps(inout vec4 dielectric, inout float grazing) {
}
#endif

// Everything at this pixel, for a base colour that has been read already.
MaterialPoint materialAt(vec4 baseColor) {
    vec2 metallicRoughness = metallicRoughnessAt();
    float r = (1.5f - 1.0f) / (1.5f + 1.0f);
    vec4 dielectric =
        has(FEATURE_DEFAULT_NUMBERS) ? vec4(vec3(r * r), 1.0f) : material.dielectricF0;
    float grazing = has(FEATURE_DEFAULT_NUMBERS) ? 1.0f : material.attenuation.w;
    applySpecularMaps(dielectric, grazing);
    vec3 normal = normalAt();
    return MaterialPoint(baseColor, metallicRoughness.x, metallicRoughness.y,
                         dielectric.rgb, dielectric.w, grazing, material.sides.x, normal,
                         occlusionAt(), emittedAt(), layersAt(normal));
}
