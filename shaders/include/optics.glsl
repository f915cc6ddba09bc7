// Formulae about light at a surface: Fresnel, GGX, lights, environment light, finite radiance.
// Compiled twice: as GLSL 4.30 and, inside a namespace that uses glm, as C++ in the unit tests.
// All vectors are unit, all cosines may be wrong by rounding, all results are finite.
#ifndef CLERESTORY_OPTICS_GLSL
#define CLERESTORY_OPTICS_GLSL

const float kPi = 3.14159265358979f;

// The largest half float; frames are stored as half floats.
const float kMaxRadiance = 65504.0f;

// Perceptual roughness (alpha = roughness^2) below which a lobe is narrower than float32 resolves
// (the relative error of D stays below 1e-3 above it) and below which lights' highlights flicker.
const float kMinRoughness = 0.045f;
const float kMinAlpha = 0.002025f;

// Cosine at which a surface seen or lit edge-on is still evaluated: keeps visibility finite.
const float kMinCosine = 1e-4f;

// Square metres. A point light nearer than 1 cm is evaluated at 1 cm.
const float kMinLightDistanceSquared = 1e-4f;

// Least difference of the cosines of a spot's inner and outer angle (KHR_lights_punctual).
const float kMinConeWidth = 1e-3f;

// x clamped to 0..1, to the fifth power. Not pow(): that is NaN for x = -1e-7 (erratum N1).
float pow5(float x) {
    float y = clamp(x, 0.0f, 1.0f);
    float y2 = y * y;
    return y2 * y2 * y;
}

// Rec. 709 luminance of linear RGB.
float luminance(vec3 c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

float maxComponent(vec3 c) {
    return max(c.x, max(c.y, c.z));
}

// What may be stored: NaN, infinities and negative light become 0, the rest is at most 65504.
// Written as comparisons, which are false for NaN in both languages.
float radianceFinite(float x) {
    return (x > 0.0f && x < 3e38f) ? min(x, kMaxRadiance) : 0.0f;
}
vec3 radianceFinite(vec3 c) {
    return vec3(radianceFinite(c.x), radianceFinite(c.y), radianceFinite(c.z));
}

// ---- Fresnel -----------------------------------------------------------------------------------

// Schlick 1994. cosTheta is the angle in the less dense medium. Against the exact curve it is up to
// 0.036 off for ior 1.5 (at 85 degrees) and must not be used below ior 1.3 (erratum G4).
// f90: reflectance at grazing, 1 but for a dielectric whose material dims its whole lobe.
vec3 fresnelSchlick(vec3 f0, vec3 f90, float cosTheta) {
    return f0 + (f90 - f0) * pow5(1.0f - cosTheta);
}

// Reflectance of a smooth dielectric for unpolarised light, exact (Cook and Torrance 1982).
// cosTheta: of the incident ray, 0..1. eta: index behind the surface / index in front of it, above
// 0. 1 beyond the critical angle, 0 where eta is 1 (there the form is 0/0 at grazing).
float fresnelDielectric(float cosTheta, float eta) {
    float c = clamp(cosTheta, 0.0f, 1.0f);
    float e = clamp(eta, 1e-3f, 1e3f);
    float e2MinusOne = (e - 1.0f) * (e + 1.0f);
    if (abs(e - 1.0f) < 1e-6f) {
        return 0.0f;
    }
    float g2 = e2MinusOne + c * c;
    if (g2 <= 0.0f) {
        return 1.0f;  // total internal reflection
    }
    float g = sqrt(g2);
    float sum = g + c;  // above 0: g is
    // g - c without cancellation, so that eta near 1 keeps its digits.
    float difference = e2MinusOne / sum;
    float s = difference / sum;
    // The divisor is c g + (1 - c^2): 0 only at g = 0, which has returned.
    float p = (c * sum - 1.0f) / (c * difference + 1.0f);
    return clamp(0.5f * s * s * (1.0f + p * p), 0.0f, 1.0f);
}

// Reflectance at normal incidence, from the index of refraction (1 and above), and back (erratum G1).
float f0FromIor(float ior) {
    float r = (ior - 1.0f) / (ior + 1.0f);
    return r * r;
}
float iorFromF0(float f0) {
    float r = sqrt(clamp(f0, 0.0f, 0.98f));
    return (1.0f + r) / (1.0f - r);
}

// ---- GGX, alpha = roughness^2 ------------------------------------------------------------------

// Density of microfacet normals per steradian (Walter et al. 2007), with the sine taken from the
// cross product: 1 - nDotH^2 has no digits left near the peak (erratum N3).
float ggxDistribution(float nDotH, float nCrossHSquared, float alpha) {
    float a = clamp(alpha, kMinAlpha, 1.0f);
    float ca = nDotH * a;
    // At least a^2 for cosines and sines that belong together; rounding may fall below.
    float k = a / max(ca * ca + nCrossHSquared, a * a);
    return nDotH > 0.0f ? k * k / kPi : 0.0f;
}

// The mean of that density over all half vectors within a disc of slopes about this one: the
// highlight of a curved smooth surface over a pixel, which one point of it would miss or overestimate. As
// distribution of slopes GGX falls off as the light of a uniform emitter on a plane at height alpha
// over a parallel one, so its sum over a disc is the form factor of a disc (Howell, catalogue, B-12).
// alphaSquared: at least kMinAlpha^2. c2, s2: squares of the half vector's cosine and sine against
// the normal. covered: the disc's radius squared, in tangents.
float ggxMeanDistribution(float c2, float s2, float alphaSquared, float covered) {
    float q = max(c2 * alphaSquared + s2, alphaSquared * 0.999f);
    float a = q - covered * c2;
    float s = sqrt(a * a + 4.0f * alphaSquared * covered * c2 * c2);
    float sum = s + abs(a);
    // Two ways to write one quotient; each keeps its digits on its own side of the disc's rim.
    float tail = 2.0f * alphaSquared / (s * sum);
    float inside = sum / (2.0f * covered * s * c2 * c2 + 1e-12f);
    return (a > 0.0f ? tail : inside) / kPi;
}

// Height-correlated Smith visibility G2 / (4 nDotL nDotV) (Heitz 2014).
float ggxVisibility(float nDotL, float nDotV, float alpha) {
    float a = max(alpha, kMinAlpha);
    float a2 = a * a;
    float l = clamp(nDotL, kMinCosine, 1.0f);
    float v = clamp(nDotV, kMinCosine, 1.0f);
    float shadowing = v * sqrt(a2 + (1.0f - a2) * l * l);
    float masking = l * sqrt(a2 + (1.0f - a2) * v * v);
    return 0.5f / (shadowing + masking);
}

// ---- lights -------------------------------------------------------------------------------------

// Irradiance per unit of intensity of a point light, per square metre; range 0 is unlimited.
// The window is the one KHR_lights_punctual recommends: 1 near the light, 0 from the range on.
float punctualAttenuation(float distanceToLight, float range) {
    float d = clamp(distanceToLight, 0.0f, 1e18f);
    float window = 1.0f;
    if (range > 0.0f) {
        float r = min(d / range, 1.0f);
        window = 1.0f - r * r * r * r;
    }
    return window / max(d * d, kMinLightDistanceSquared);
}

// Share of the intensity of a spot light at an angle from its axis (KHR_lights_punctual).
float spotAttenuation(float cosAngle, float cosInner, float cosOuter) {
    float t = clamp((cosAngle - cosOuter) / max(cosInner - cosOuter, kMinConeWidth), 0.0f, 1.0f);
    return t * t;
}

// ---- environment light -------------------------------------------------------------------------

// Where to look up environmentBrdfTable(size): columns are uniform in sqrt(n.v), because values
// change most at grazing angles; its first and last entries represent 0 and 1; texels are read at their centres.
vec2 environmentBrdfCoordinate(float nDotV, float roughness, float size) {
    vec2 p = vec2(sqrt(clamp(nDotV, 0.0f, 1.0f)), clamp(roughness, 0.0f, 1.0f));
    return (p * (size - 1.0f) + 0.5f) / size;
}

// Share of a uniform environment that the specular lobe returns, 0..1: split sum f0 A + B (Karis
// 2013), with f90 as in fresnelSchlick() f0 A + f90 B, times what multiple scattering adds,
// 1 + f0 (1 / (A + B) - 1) (Turquin 2019).
vec3 specularEnvironment(vec3 f0, float f90, vec2 ab) {
    float single = clamp(ab.x + ab.y, 0.05f, 1.0f);  // what a white lobe returns in one bounce
    vec3 scattered = f0 * ab.x + f90 * ab.y;
    return clamp(scattered * (1.0f + f0 * (1.0f / single - 1.0f)), 0.0f, 1.0f);
}

// What the specular lobe leaves to the diffuse one below it. specular: specularEnvironment(). The
// largest channel counts, so that a coloured lobe does not tint the diffuse (KHR_materials_specular).
float diffuseWeight(vec3 specular) {
    return clamp(1.0f - maxComponent(specular), 0.0f, 1.0f);
}

// Irradiance / pi about a unit normal, from nine coefficients as diffuseHarmonics() makes them.
// Ringing behind a very strong light would be negative: cut at 0.
vec3 harmonics9(vec3 n, vec3 c0, vec3 c1, vec3 c2, vec3 c3, vec3 c4, vec3 c5, vec3 c6, vec3 c7,
                vec3 c8) {
    vec3 linearPart = c0 + c1 * n.y + c2 * n.z + c3 * n.x;
    vec3 quadraticPart = c4 * (n.x * n.y) + c5 * (n.y * n.z) + c6 * (3.0f * n.z * n.z - 1.0f) +
                         c7 * (n.x * n.z) + c8 * (n.x * n.x - n.y * n.y);
    return max(linearPart + quadraticPart, vec3(0.0f));
}

// Factors of the linear and the quadratic coefficients with which these show what a wide lobe of GGX
// gathers about its axis, instead of a cosine. roughness: 0.7..1; fitted to the lobe's integrals,
// 0.003 off.
vec2 lobeBands(float roughness) {
    float x = 1.0f - roughness;
    return vec2(1.0f + x * (0.32f + 0.6f * x), 1.0f + x * (1.53f + 3.45f * x));
}

#endif
