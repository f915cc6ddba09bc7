// Light that reaches a surface, and what of it the surface sends to the eye: lamps one by one,
// the environment as nine harmonics and a cube prefiltered by roughness.

layout(binding = UNIT_ENVIRONMENT) uniform samplerCube environmentMap;
layout(binding = UNIT_ENVIRONMENT_BRDF) uniform sampler2D environmentBrdf;
layout(binding = UNIT_LIGHTS) uniform samplerBuffer lightTable;

struct Surface {
    vec3 normal;
    vec3 toEye;
    float nDotV;
    vec3 diffuse;  // albedo of what is not metal
    vec3 f0;
    float roughness;
    vec2 brdf;            // split sum at nDotV and roughness
    vec3 reflectance;     // of the specular lobe in a uniform environment
};

vec3 lampLight(Surface s, int first) {
    vec4 place = texelFetch(lightTable, first);      // w: 0 for a direction
    vec4 power = texelFetch(lightTable, first + 1);  // w: range
    // spotAttenuation() as a line in the cosine: dot(cone.xyz, toLight) + cone.w, before clamping.
    vec4 cone = texelFetch(lightTable, first + 2);

    vec3 toLight = place.xyz - positionEye * place.w;
    float distanceToLight = length(toLight);
    toLight = direction(toLight);
    float nDotL = dot(s.normal, toLight);
    float inCone = clamp(dot(cone.xyz, toLight) + cone.w, 0.0f, 1.0f);
    vec3 irradiance = power.rgb * (max(nDotL, 0.0f) * inCone * inCone *
                                   punctualAttenuation(distanceToLight, power.w));

    vec3 halfway = direction(toLight + s.toEye);
    vec3 across = cross(s.normal, halfway);
    float alpha = s.roughness * s.roughness;
    vec3 fresnel = fresnelSchlick(s.f0, dot(s.toEye, halfway));
    float lobe = ggxDistribution(dot(s.normal, halfway), dot(across, across), alpha) *
                 ggxVisibility(nDotL, s.nDotV, alpha);
    // What several bounces between microfacets add to one (Turquin 2019).
    vec3 bounces = 1.0f + s.f0 * (1.0f / clamp(s.brdf.x + s.brdf.y, 0.05f, 1.0f) - 1.0f);
    return irradiance * (fresnel * bounces * lobe +
                         (1.0f - maxComponent(fresnel)) * s.diffuse / kPi);
}

vec3 lampsLight(Surface s) {
    if (!has(FEATURE_LIGHTS)) return vec3(0.0f);
    int first = int(drawNumbers.x) * LIGHT_ROWS;
    int end = first + int(drawNumbers.y) * LIGHT_ROWS;
    vec3 sum = vec3(0.0f);
    do {  // a draw with this feature has at least one light
        sum += lampLight(s, first);
        first += LIGHT_ROWS;
    } while (first < end);
    return sum;
}

vec3 environmentLight(Surface s) {
    vec3 around = harmonics9(s.normal, view.harmonics[0].xyz, view.harmonics[1].xyz,
                             view.harmonics[2].xyz, view.harmonics[3].xyz, view.harmonics[4].xyz,
                             view.harmonics[5].xyz, view.harmonics[6].xyz, view.harmonics[7].xyz,
                             view.harmonics[8].xyz);
    vec3 mirrored = textureLod(environmentMap, reflect(-s.toEye, s.normal),
                               s.roughness * view.environment.x).rgb * view.environment.y;
    return s.reflectance * mirrored + diffuseWeight(s.reflectance) * s.diffuse * around;
}
