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

// The lobe of a mirror as one look-up of a map that is filtered for round lobes.
struct RoundLobe {
    vec3 along;   // unit
    float alpha;  // GGX alpha of a lobe seen from its own normal
};

// At an angle the visible microfacets turn towards the eye, which lifts the lobe off the surface, and
// the lobe is narrower across the plane of incidence. normal, toEye: unit. nDotV: above 0. The factors
// are fitted to the integral of GGX: over 600 lobes of roughness 0.15 to 0.65 at all angles in three HDR
// maps the root mean square error of the displayed value is 0.059. With the mirror's direction and the
// width of alpha it is 0.089. At n.v below 0.2: 0.085 and 0.145.
RoundLobe roundLobe(vec3 normal, vec3 toEye, float nDotV, float alpha) {
    // The view direction, stretched so that the microfacets become a sphere (Heitz 2018).
    float stretched = sqrt(alpha * alpha * (1.0f - nDotV * nDotV) + nDotV * nDotV);
    float perSlope = 1.0f / (0.5f * stretched + nDotV);
    vec3 facet = normalize(normal + (toEye - normal * nDotV) * (0.8f * alpha * alpha * perSlope));
    float cosine = max(dot(toEye, facet), 0.0f);
    return RoundLobe(reflect(-toEye, facet), alpha * min(1.7f * cosine * stretched * perSlope, 1.0f));
}

// A lobe of slope `lobe`, 2 alpha, about the mirrored direction `along`, as one look-up or one path.
RoundLobe mirroredLobe(vec3 along, vec3 toEye, float lobe) {
    if (!(lobe > 0.0f)) return RoundLobe(along, 0.0f);
    vec3 halfway = along + toEye;
    vec3 normal = halfway * inversesqrt(max(dot(halfway, halfway), 1e-12f));
    return roundLobe(normal, toEye, max(dot(normal, toEye), kMinCosine), 0.5f * lobe);
}

// One of several look-ups along the plane of incidence that together represent a lobe.
struct LobePart {
    vec3 along;    // unit
    float alpha;   // as wide as the lobe is there across the plane
    float weight;  // relative to the others
};

// Part i of `count`: the microfacets at the quantiles of their slopes in the plane, whose distribution
// is 1 / (2 alpha (1 + t^2)^(3/2)) with t = slope / alpha. Each is as wide across as GGX is there, or as
// wide as the distance of its neighbours. side: unit, tangent, towards the eye. The error stated above is
// 0.047 with four parts and 0.046 with six.
LobePart partOfLobe(vec3 normal, vec3 side, vec3 toEye, float alpha, int i, int count) {
    float u = (2.0f * float(i) + 1.0f) / float(count) - 1.0f;
    float perRoot = inversesqrt(1.0f - u * u);  // |u| is below 1
    vec3 facet = normal + side * (alpha * u * perRoot);
    float facing = max(dot(toEye, facet), 0.0f);
    vec3 halfway = normalize(facet);
    float cosine = max(dot(toEye, halfway), 0.0f);
    vec3 along = reflect(-toEye, halfway);
    float above = max(dot(along, normal), 0.0f);
    float across = 0.85f * perRoot * cosine;
    float apart = 0.2f * perRoot * perRoot * perRoot / float(count);
    // The last factor is near masking, which is 0 below the surface.
    return LobePart(along, alpha * min(max(across, apart), 1.0f),
                    facing * above / (above + 0.3f * alpha + 1e-6f));
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
