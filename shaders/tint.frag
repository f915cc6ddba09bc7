// Transmittance of glass and blended surfaces for a punctual light, and their depth as seen from it.
#include "include/block_macros.glsl"
#include "include/features.glsl"
#define VARYING in
#include "include/surface_varyings.glsl"
#include "include/optics.glsl"
#include "include/material.glsl"
#include "include/glass.glsl"

out vec4 tint;  // alpha: depth, greater is nearer

// A factor for the face where light enters a body or leaves it: the absorption between the face and the
// body's middle, or its inverse, so that the product over both faces is the absorption between them.
// The inverse occurs in hollow bodies, twice on a way; halves hold its limit squared.
const float kMaxInverse = 240.0f;
vec3 factorOfFace(float distance, bool enters) {
    float fromMiddle = distance - drawNumbers.x;
    vec3 left = absorption(material.attenuation.rgb, material.glass.w, abs(fromMiddle));
    if ((fromMiddle < 0.0f) == enters) return left;
    return 1.0f / max(left, vec3(1.0f / kMaxInverse));
}

// Light passes straight through a body, without refraction.
vec3 throughGlass(vec3 baseColor) {
    bool parallel = view.forward.w > 0.5f;
    vec3 ahead = parallel ? view.forward.xyz : direction(positionEye);
    float c = abs(dot(direction(vertexNormal), ahead));
    float ior = max(material.glass.y, 1.0f);
    float fresnel = fresnelOfBody(c, ior, material.dielectricF0.w);
    float transmission = material.glass.x;
    if (has(FEATURE_TRANSMISSION_MAP)) {
        transmission *= texture(transmissionMap, texCoordOf(SLOT_TRANSMISSION)).r;
    }
    float clear = clearShare(transmission, metallicRoughnessAt().x);
    if (has(FEATURE_SOLID)) {
        float distance = parallel ? dot(positionEye, view.forward.xyz) : length(positionEye);
        vec3 color = gl_FrontFacing ? baseColor : vec3(1.0f);
        return clear * (1.0f - fresnel) * color * factorOfFace(distance, gl_FrontFacing);
    }
    float thickness = material.glass.z * modelScale;
    if (has(FEATURE_THICKNESS_MAP)) {
        thickness *= texture(thicknessMap, texCoordOf(SLOT_THICKNESS)).g;
    }
    float bent = sqrt(max(1.0f - (1.0f - c * c) / (ior * ior), 1e-6f));
    vec3 left = absorption(material.attenuation.rgb, material.glass.w, thickness / bent);
    return clear * baseColor * paneShares(fresnel, left).transmitted;
}

void main() {
    vec4 base = baseColorAt();
    if (has(FEATURE_MASK) && base.a < material.emissive.w) discard;
    float coverage = has(FEATURE_BLEND) ? clamp(base.a, 0.0f, 1.0f) : 1.0f;
    vec3 through = has(FEATURE_GLASS) ? throughGlass(clamp(base.rgb, 0.0f, 1.0f)) : vec3(0.0f);
    tint = vec4(vec3(1.0f - coverage) + coverage * through, gl_FragCoord.z);
}
