// Light that reaches a point of a surface, and what of it the surface sends to who looks: lamps one
// by one, the environment as nine harmonics and a cube prefiltered by roughness.

layout(binding = UNIT_ENVIRONMENT) uniform samplerCube environmentMap;
layout(binding = UNIT_ENVIRONMENT_BRDF) uniform sampler2D environmentBrdf;
layout(binding = UNIT_LIGHTS) uniform samplerBuffer lightTable;

// Texels along an edge of environmentBrdf.
const float kBrdfSize = 32.0f;

// A point of a surface as light meets it.
struct Surface {
    vec3 normal;
    vec3 toEye;  // to who looks: the eye, or where a ray came from
    float nDotV;
    vec3 diffuse;  // albedo of what is not metal
    vec3 f0;
    float f90;
    float roughness;
    vec3 reflectance;  // of the specular lobe in a uniform environment
    // For lamps, the same for each of them:
    float alphaSquared;
    float masking;  // Smith's root for the eye
    vec3 bounces;   // what several bounces between microfacets add to one (Turquin 2019)
};

Surface surfaceOf(MaterialPoint m, vec3 toEye) {
    Surface s;
    s.normal = m.normal;
    s.toEye = toEye;
    s.nDotV = max(dot(s.normal, s.toEye), kMinCosine);
    s.diffuse = m.baseColor.rgb * (1.0f - m.metallic);
    s.f0 = mix(m.dielectricF0, m.baseColor.rgb, m.metallic);
    s.f90 = mix(m.specular, 1.0f, m.metallic);
    s.roughness = m.roughness;
    vec2 brdf = textureLod(environmentBrdf,
                           environmentBrdfCoordinate(s.nDotV, s.roughness, kBrdfSize), 0.0f).rg;
    s.reflectance = specularEnvironment(s.f0, s.f90, brdf);
    float lobe = max(s.roughness, kMinRoughness);
    float alpha = lobe * lobe;
    s.alphaSquared = alpha * alpha;
    s.masking = sqrt(s.alphaSquared + (1.0f - s.alphaSquared) * s.nDotV * s.nDotV);
    s.bounces = 1.0f + s.f0 * (1.0f / clamp(brdf.x + brdf.y, 0.05f, 1.0f) - 1.0f);
    return s;
}

// The same surface for a ray that covers half vectors over `slope` of its normal, and so sees an
// average of lobes: about one lobe that is as much wider (Tokuyoshi and Kaplanyan 2019, whose bound
// this is), where a single point of it would flash or stay dark.
const float kMostWidening = 0.18f;
Surface widened(Surface s, float slope) {
    s.alphaSquared = min(s.alphaSquared + min(slope * slope, kMostWidening), 1.0f);
    s.masking = sqrt(s.alphaSquared + (1.0f - s.alphaSquared) * s.nDotV * s.nDotV);
    s.roughness = max(s.roughness, sqrt(sqrt(s.alphaSquared)));
    return s;
}

// ggxDistribution() * ggxVisibility() of optics.glsl as one quotient, what is common to all lamps
// taken out: compilers for processors do not take it out of the loop. halfway need not be unit.
float ggxLobe(Surface s, vec3 halfway, float nDotL) {
    float a2 = s.alphaSquared;
    float perLength = 1.0f / max(dot(halfway, halfway), 1e-12f);
    float nDotH = dot(s.normal, halfway);
    vec3 across = cross(s.normal, halfway);
    float q = max((nDotH * nDotH * a2 + dot(across, across)) * perLength, 1e-9f);
    float l = max(nDotL, kMinCosine);
    float smith = s.nDotV * sqrt(a2 + (1.0f - a2) * l * l) + l * s.masking;
    return (0.5f / kPi) * a2 / (q * q * smith);
}

// What the surface sends on of light that falls in along toLight, unit; nDotL: normal . toLight.
vec3 sentOn(Surface s, vec3 toLight, float nDotL) {
    vec3 halfway = toLight + s.toEye;
    float eyeDotH = dot(s.toEye, halfway) * inversesqrt(max(dot(halfway, halfway), 1e-12f));
    vec3 fresnel = fresnelSchlick(s.f0, s.f90, eyeDotH);
    return fresnel * s.bounces * ggxLobe(s, halfway, nDotL) +
           (1.0f - maxComponent(fresnel)) * (1.0f / kPi) * s.diffuse;
}

// Of a directional lamp whose rows in the table begin at `first`.
vec3 sunLight(Surface s, int first) {
    vec3 toLight = texelFetch(lightTable, first).xyz;
    float nDotL = dot(s.normal, toLight);
    return texelFetch(lightTable, first + 1).rgb * max(nDotL, 0.0f) * sentOn(s, toLight, nDotL);
}

// Of any lamp.
vec3 lampLight(Surface s, vec3 position, int first) {
    vec4 place = texelFetch(lightTable, first);      // w: 0 for a direction
    vec4 power = texelFetch(lightTable, first + 1);  // w: 1 / range^2, 0 without a range
    // spotAttenuation() as a line in the cosine: dot(cone.xyz, toLight) + cone.w, before clamping.
    vec4 cone = texelFetch(lightTable, first + 2);

    vec3 toLight = place.xyz - position * place.w;
    float squared = max(dot(toLight, toLight), 1e-12f);
    toLight *= inversesqrt(squared);
    float nDotL = dot(s.normal, toLight);
    float inCone = clamp(dot(cone.xyz, toLight) + cone.w, 0.0f, 1.0f);
    float inRange = min(squared * power.w, 1.0f);  // punctualAttenuation() of the square
    float falloff = max(nDotL, 0.0f) * inCone * inCone * (1.0f - inRange * inRange) /
                    max(squared, kMinLightDistanceSquared);
    return power.rgb * falloff * sentOn(s, toLight, nDotL);
}

// The lamps that stand in the table from number `first` on, at least one. position: of the surface,
// in eye space.
vec3 lampsLight(Surface s, vec3 position, int first, int count) {
    int row = HARMONIC_ROWS + first * LIGHT_ROWS;
    int end = row + count * LIGHT_ROWS;
    vec3 sum = vec3(0.0f);
    do {
        sum += lampLight(s, position, row);
        row += LIGHT_ROWS;
    } while (row < end);
    return sum;
}

// Prefiltered by roughness: level k of the last holds roughness k / last.
vec3 environmentAlong(vec3 towards, float roughness) {
    return textureLod(environmentMap, towards, roughness * view.environment.x).rgb *
           view.environment.y;
}

// Irradiance / pi of the environment, its intensity folded in. Out of the light table, because each
// number of a uniform block costs a software rasteriser a check of its place, in every pixel anew:
// 6 % of the processor time of Sponza's frame.
vec3 diffuseAround(vec3 normal) {
    vec4 a = texelFetch(lightTable, 0), b = texelFetch(lightTable, 1);
    vec4 c = texelFetch(lightTable, 2), d = texelFetch(lightTable, 3);
    vec4 e = texelFetch(lightTable, 4), f = texelFetch(lightTable, 5);
    vec4 g = texelFetch(lightTable, 6);
    return harmonics9(normal, a.xyz, vec3(a.w, b.xy), vec3(b.zw, c.x), c.yzw, d.xyz,
                      vec3(d.w, e.xy), vec3(e.zw, f.x), f.yzw, g.xyz);
}

// What the surface makes of the light around it. mirrored: the radiance that its specular lobe
// gathers, from the environment or from what stands before it (reflection.glsl).
vec3 environmentLight(Surface s, vec3 mirrored) {
    return s.reflectance * mirrored +
           diffuseWeight(s.reflectance) * s.diffuse * diffuseAround(s.normal);
}
