// Formulae of material layers, after optics.glsl and sampling.glsl. Compiled as GLSL 4.30 and as C++
// (see optics.glsl). All results are finite.
#ifndef CLERESTORY_LAYERS_GLSL
#define CLERESTORY_LAYERS_GLSL

// ---- clear coat (KHR_materials_clearcoat) --------------------------------------------------------

const vec3 kClearcoatF0 = vec3(0.04f);  // index 1.5

// ---- sheen (KHR_materials_sheen) -----------------------------------------------------------------
// Fibres that stand upright: the distribution and the shadowing of Estevez and Kulla 2017. Their
// albedo exceeds 1 below this roughness, and edge-on.

const float kMinSheenRoughness = 0.1f;
const float kMinSheenCosine = 0.08f;

// Logarithm of Lambda below a cosine of 1/2 (their fit).
float sheenLambdaFit(float c, float alpha) {
    float t = (1.0f - alpha) * (1.0f - alpha);
    float a = mix(21.5473f, 25.3245f, t);
    float b = mix(3.82987f, 3.32435f, t);
    float p = mix(0.19823f, 0.16801f, t);
    float d = mix(-1.97760f, -1.27393f, t);
    float e = mix(-4.32054f, -4.85967f, t);
    return a / (1.0f + b * pow(c, p)) + d * c + e;
}
float sheenLambda(float cosine, float alpha) {
    float c = clamp(cosine, kMinSheenCosine, 1.0f);
    float steep = sheenLambdaFit(min(c, 0.5f), alpha);
    float flatter = 2.0f * sheenLambdaFit(0.5f, alpha) - sheenLambdaFit(max(1.0f - c, 1e-4f), alpha);
    return exp(c < 0.5f ? steep : flatter);
}

// The lobe of white fibres times the cosine to the light.
float sheenLobe(float nDotL, float nDotV, float nDotH, float roughness) {
    float r = max(roughness, kMinSheenRoughness);
    float alpha = r * r;
    float sine2 = clamp(1.0f - nDotH * nDotH, 1e-6f, 1.0f);
    float density = (2.0f + 1.0f / alpha) * pow(sine2, 0.5f / alpha) / (2.0f * kPi);
    float shadowing = 1.0f / (1.0f + sheenLambda(nDotV, alpha) + sheenLambda(nDotL, alpha));
    return nDotL > 0.0f ? density * shadowing / (4.0f * max(nDotV, kMinSheenCosine)) : 0.0f;
}

// Integral of the lobe over the hemisphere, fitted: 0.03 off at most, 0.008 in the root mean square.
float sheenAlbedo(float nDotV, float roughness) {
    float r = clamp(roughness, kMinSheenRoughness, 1.0f);
    float c = clamp(nDotV, kMinSheenCosine, 1.0f);
    float a = 1.7105f + r * (-11.0639f + r * (21.2516f + r * (-16.3101f + r * 4.2989f)));
    float b = -21.2007f + r * (106.4505f + r * (-226.6911f + r * (213.4086f - r * 74.0856f)));
    float d = 9.1001f + r * (-71.216f + r * (182.0604f + r * (-189.7282f + r * 70.2979f)));
    return clamp(exp(a + c * (b + c * d)), 0.0f, 1.0f);
}

// Mean direction of the lobe, not unit: x along the surface towards the eye (fibres send light back
// where it comes from), y along the normal. Fitted, 0.04 off at most where the albedo counts.
vec2 sheenAxis(float nDotV, float roughness) {
    float r = clamp(roughness, kMinSheenRoughness, 1.0f);
    float c = clamp(nDotV, kMinSheenCosine, 1.0f);
    float aside = 0.5701f - 1.0982f * r + 0.6619f * r * r + c * (0.7696f - 0.9466f * r + 0.4288f * c);
    float up = -0.0161f + r * (1.7149f + r * (-2.0235f + r * 0.8323f)) +
               c * (0.0535f + r * (0.5993f - r * 0.3501f)) +
               c * c * (-0.3667f + r * 0.0447f + c * 0.0569f);
    return vec2(aside * sqrt(max(1.0f - c * c, 0.0f)), up);
}

// How far the lobe is spread in its plane: the parts of two axes, the normal and the one in the middle between
// the normal and the surface's direction towards the eye, in the mean of products of its directions. An axis
// alone has the part 1; a ring about it has a part below 0. Fitted to integrals of the lobe: the mean of z z
// along the normal is 0.01 off, that of x z 0.02 where the albedo counts.
vec2 sheenSpread(vec2 axis) {
    float both = axis.x * axis.y;
    float upward = axis.y * axis.y * (2.205f - 0.705f * axis.y) - 0.5f;
    return vec2(upward - 0.5f * both, 2.0f * both);
}

// ---- iridescence (KHR_materials_iridescence) -----------------------------------------------------
// A thin film by Belcour and Barla 2017: Airy's sum over the orders of interference, each weighted by
// the spectral sensitivity's Fourier transform, which they fitted with Gaussians. Both polarisations
// have a sum of their own: near the angle at which one of them is not reflected, the product of mean
// reflectances is several times the mean of the products.

vec3 filmSensitivity(float pathDifference) {
    float phase = 2.0f * kPi * pathDifference * 1e-9f;
    float p2 = phase * phase;
    vec3 gaussian =
        vec3(exp(-p2 * 4.3278e9f), exp(-p2 * 9.3046e9f), exp(-p2 * 6.6121e9f));
    vec3 wave = vec3(cos(1.6810e6f * phase), cos(1.7953e6f * phase), cos(2.2084e6f * phase));
    // value * sqrt(2 pi variance) / 1.0685e-7 of each Gaussian.
    vec3 t = vec3(0.846590f, 1.000222f, 1.001122f) * gaussian * wave;
    t.x += 0.153868f * cos(2.2399e6f * phase) * exp(-4.5282e9f * p2);
    return vec3(3.2404542f * t.x - 1.5371385f * t.y - 0.4985314f * t.z,
                -0.9692660f * t.x + 1.8760108f * t.y + 0.0415560f * t.z,
                0.0556434f * t.x - 0.2040259f * t.y + 1.0572252f * t.z);
}

// Of one polarisation. first, second: amplitudes of reflection at the film and at the base, from
// outside, -1..1. once, twice: filmSensitivity() of light that crosses the film one more time, and two.
vec3 filmOfPolarisation(float first, vec3 second, vec3 once, vec3 twice) {
    float transmitted = 1.0f - first * first;
    vec3 around = clamp(-first * second, -0.99995f, 0.99995f);  // from base to film and back
    vec3 behind = transmitted * transmitted * second * second / (vec3(1.0f) - around * around);
    return vec3(first * first) + behind +
           2.0f * (behind - vec3(transmitted)) * around * (once + around * twice);
}

// Reflectance of a base with reflectance f0 at normal incidence under a film, 0..1.
// thickness: nanometres.
vec3 filmReflectance(float cosTheta, float filmIor, float thickness, vec3 f0) {
    float c1 = clamp(cosTheta, 1e-4f, 1.0f);
    // A film of no thickness is none.
    float eta = mix(1.0f, max(filmIor, 1.0f), smoothstep(0.0f, 0.03f, thickness));
    float c2 = sqrt(max(1.0f - (1.0f - c1 * c1) / (eta * eta), 1e-8f));
    vec3 root = sqrt(clamp(f0, 1e-4f, 0.9999f));
    vec3 ior = (vec3(1.0f) + root) / (vec3(1.0f) - root);
    vec3 sine3 = eta / ior * sqrt(1.0f - min(c2 * c2, 1.0f));
    vec3 c3 = sqrt(max(vec3(1.0f) - sine3 * sine3, vec3(0.0f)));
    float pathDifference = 2.0f * eta * min(thickness, 1e5f) * c2;
    vec3 once = filmSensitivity(pathDifference);
    vec3 twice = filmSensitivity(2.0f * pathDifference);
    vec3 across = filmOfPolarisation((c1 - eta * c2) / (c1 + eta * c2),
                                     (vec3(eta * c2) - ior * c3) / (vec3(eta * c2) + ior * c3),
                                     once, twice);
    vec3 along = filmOfPolarisation((eta * c1 - c2) / (eta * c1 + c2),
                                    (ior * c2 - eta * c3) / (ior * c2 + eta * c3), once, twice);
    return clamp(0.5f * (across + along), 0.0f, 1.0f);
}

// The reflectance at normal incidence whose Schlick curve has `reflectance` at this cosine.
vec3 f0Through(vec3 reflectance, float f90, float cosTheta) {
    float rise = min(pow5(1.0f - cosTheta), 0.95f);
    return clamp((reflectance - vec3(f90 * rise)) / (1.0f - rise), 0.0f, 1.0f);
}

// ---- anisotropy (KHR_materials_anisotropy) -------------------------------------------------------

// Alphas along the grain and across it.
vec2 anisotropicAlphas(float alpha, float anisotropy) {
    return vec2(mix(alpha, 1.0f, anisotropy * anisotropy), alpha);
}

// GGX with two alphas times Smith's height-correlated visibility (Heitz 2014) and the cosine to the
// light. Vectors: x along the grain, y across it, z along the normal; half vector unit.
float ggxAnisotropicLobe(vec3 toLight, vec3 toEye, vec3 halfway, vec2 alphas) {
    float ax = max(alphas.x, kMinAlpha);
    float ay = max(alphas.y, kMinAlpha);
    float hx = halfway.x / ax;
    float hy = halfway.y / ay;
    float q = max(hx * hx + hy * hy + halfway.z * halfway.z, 1e-9f);
    float l = clamp(toLight.z, kMinCosine, 1.0f);
    float v = clamp(toEye.z, kMinCosine, 1.0f);
    float lx = ax * toLight.x;
    float ly = ay * toLight.y;
    float vx = ax * toEye.x;
    float vy = ay * toEye.y;
    float smith = l * sqrt(vx * vx + vy * vy + v * v) + v * sqrt(lx * lx + ly * ly + l * l);
    return max(toLight.z, 0.0f) * 0.5f / (kPi * ax * ay * q * q * smith);
}

// ---- dispersion (KHR_materials_dispersion) -------------------------------------------------------

// Indices for red, green and blue: Cauchy's curve as the extension simplifies it, with the Abbe number
// 20 / dispersion.
vec3 dispersedIors(float ior, float dispersion) {
    float spread = (ior - 1.0f) * 0.025f * dispersion;
    return max(vec3(ior - spread, ior, ior + spread), vec3(1.0f));
}

#endif
