// Sampling: low-discrepancy points, GGX directions, tangent frames, levels of a cube map.
// Needs optics.glsl before it. Compiled as GLSL 4.30 and as C++ (see optics.glsl).
#ifndef CLERESTORY_SAMPLING_GLSL
#define CLERESTORY_SAMPLING_GLSL

// The bits of i mirrored at the binary point: 0, 1/2, 1/4, 3/4, 1/8 ... Below 1 for every i, as
// only the 24 bits that a float holds are kept.
float radicalInverse(uint i) {
    return float(bitfieldReverse(i) >> 8u) * (1.0f / 16777216.0f);
}

// Point i of n of the Hammersley set; x at the middle of its stratum, both in [0, 1).
vec2 hammersley(uint i, uint n) {
    return vec2((float(i) + 0.5f) / float(max(n, 1u)), radicalInverse(i));
}

// Microfacet normal about +Z with the density D(h) (n.h) of GGX; u in [0, 1)^2, u.x the turn.
// Sine and cosine each have their own formula, so that neither loses digits at the peak.
vec3 ggxHalfVector(vec2 u, float alpha) {
    float a2 = alpha * alpha;
    float turn = 2.0f * kPi * u.x;
    float w = clamp(u.y, 0.0f, 1.0f);
    // 1 - w + a2 w; 0 only at w = 1, alpha = 0.
    float divisor = max(1.0f - w + a2 * w, 1e-12f);
    float sine = sqrt(min(a2 * w / divisor, 1.0f));
    return vec3(sine * cos(turn), sine * sin(turn), sqrt(max(1.0f - w, 0.0f) / divisor));
}

// Visible microfacet normal, density D(h) max(v.h, 0) G1(v) / (n.v); about +Z, the eye
// along v (Dupuy and Benyoub 2023: a cap of the sphere that the stretched normals make). u in
// [0, 1)^2, u.x the turn. Unit, z above 0.
vec3 ggxVisibleNormal(vec2 u, vec3 v, float alpha) {
    vec3 stretched = normalize(vec3(alpha * v.x, alpha * v.y, max(v.z, kMinCosine)));
    float turn = 2.0f * kPi * u.x;
    float z = (1.0f - u.y) * (1.0f + stretched.z) - stretched.z;
    float sine = sqrt(clamp(1.0f - z * z, 0.0f, 1.0f));
    vec3 h = vec3(sine * cos(turn), sine * sin(turn), z) + stretched;
    return normalize(vec3(alpha * h.x, alpha * h.y, max(h.z, 1e-6f)));
}

// The weight of a direction that was sampled from visible normals:
// G2 / G1(v) of Smith's height-correlated masking (Heitz 2014), 0..1; 0 below the surface.
float ggxShareOfVisible(float nDotL, float nDotV, float alpha) {
    float a2 = alpha * alpha;
    float l = max(nDotL, 0.0f);
    float v = max(nDotV, kMinCosine);
    float rootL = sqrt(a2 + (1.0f - a2) * l * l);
    float rootV = sqrt(a2 + (1.0f - a2) * v * v);
    return l * (v + rootV) / max(v * rootL + l * rootV, 1e-12f);
}

// Density of mirrored directions about them, per steradian.
float ggxVisibleDensity(float nDotH, float nCrossHSquared, float nDotV, float alpha) {
    float a2 = alpha * alpha;
    float v = max(nDotV, kMinCosine);
    return 0.5f * ggxDistribution(nDotH, nCrossHSquared, alpha) /
           (v + sqrt(a2 + (1.0f - a2) * v * v));
}

// Roughness of a prefiltered map's level that is as wide as a direction's share 1 / (samples pdf)
// of the sphere: a texel of a plain chain is as wide as a lobe when it is sqrt(6) alpha of a face's
// edge (erratum R1), and a face's texels cover 4 pi / 6 of the sphere.
float sampleRoughness(float pdf, float samples) {
    float angle = 1.0f / max(samples * pdf, 1e-12f);
    return min(sqrt(sqrt(angle / (4.0f * kPi))), 1.0f);
}

// Columns tangent, bitangent, normal of a right-handed orthonormal frame about a unit normal,
// without a singular direction (Duff et al. 2017).
mat3 frameAbout(vec3 n) {
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z);  // |s + n.z| is at least 1
    float b = n.x * n.y * a;
    return mat3(vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x),
                vec3(b, s + n.y * n.y * a, -n.y), n);
}

// Level of a plain cube map chain whose texel is as wide as the lobe: log2(sqrt(6) alpha w)
// (erratum R1). Exactly 0 for roughness 0; at most the last level.
float environmentLod(float roughness, float faceSize, float levels) {
    float lod = log2(max(2.44948974f * roughness * roughness * faceSize, 1.0f));
    return clamp(lod, 0.0f, max(levels - 1.0f, 0.0f));
}

// Level for one of `samples` directions drawn with density pdf (per steradian) from a cube map:
// its texel covers the sample's share 1 / (samples pdf) of the sphere (Krivanek and Colbert 2008).
float sampleLod(float pdf, float samples, float faceSize) {
    float sampleAngle = 1.0f / max(samples * pdf, 1e-12f);
    float texelAngle = 4.0f * kPi / (6.0f * faceSize * faceSize);
    return 0.5f * log2(max(sampleAngle / texelAngle, 1.0f));
}

#endif
