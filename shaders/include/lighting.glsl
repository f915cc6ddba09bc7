// Light that reaches a surface point, and the radiance that the surface sends towards `toEye`: from
// each light, and from the environment as nine harmonics and a cube prefiltered by roughness.

#include "include/layers.glsl"
#include "include/surface_light.glsl"

// Layers that a surface may have here: those of the draw, or those of any surface that a ray may hit.
#define shades(bit) ((SHADED_LAYERS & (bit)) != 0u)

// Texels along an edge of environmentBrdf.
const float kBrdfSize = 32.0f;

// The half vectors within a pixel, or within the cone of a ray, as an ellipse of slopes about that of
// the surface; see covering().
struct Covered {
    vec3 x, y;      // columns of a root of its covariance
    float area;     // over pi: the square of an equal disc's radius
    float trace;    // of the covariance and one alpha squared
    float scale;    // from distances in the ellipse's axes to those in the equal disc's
    float weight;   // factor on the lobe
};

// A surface point for lighting.
struct Surface {
    vec3 normal;
    vec3 toEye;  // towards the eye, or the origin of a ray
    float nDotV;
    vec3 diffuse;  // albedo of what is not metal
    float roughness;
    vec3 reflectance;  // of the specular lobe in a uniform environment
    // glTF mixes a metal with a dielectric, and only the lobe of the dielectric reduces the diffuse one:
    // the fraction that remains in a uniform environment, and its greatest reflectance at normal
    // incidence and edge-on.
    float diffuseShare;
    vec2 dielectric;
    SurfaceLight light;  // if VIEW_SURFACE_LIGHT
    Layers layers;
    float clearcoatReflectance;  // of a uniform environment, times the coat's share
    float sheenAlbedo;
    float belowSheen, belowClearcoat;  // factors of these layers on the layers below them
    // For lights, the same for each of them:
    float shadowOffset;  // see shadowAt()
    float alphaSquared;
    float masking;  // Smith's root for the eye
    // Of the specular lobe, at normal incidence and at grazing, with several bounces between microfacets
    // (Turquin 2019).
    vec3 f0;
    vec3 f90;
    bool averages;  // highlights are averaged over `covered`
#if SCATTERS_LIGHTS
    bool bends;     // the lobe is that of light bent by two faces; see scattering.glsl
    float between;  // metres between these faces, over the index of what is there
    bool inner;     // of such a lobe: lights behind the far wall do not count, which scatters their light
#endif
    float densest, clearcoatDensest;  // no mean is denser than this
    Covered covered;
    Covered clearcoatCovered;  // if the coat has lobes of lights
};

// Reflected light leaves the surface above its face. The eye and any direction above the face are at
// most 180 degrees less the eye's elevation apart, and half of that is the greatest angle of incidence
// on a facet. Without this limit bumps and smoothed normals that face away further would have a rim of
// full reflection.
// faceCosineSquared: of the eye and the face's normal. Returns the least cosine.
float leastCosineOver(float faceCosineSquared) {
    float sine = sqrt(clamp(1.0f - faceCosineSquared, 0.0f, 1.0f));
    return max(sqrt(0.5f - 0.5f * sine), kMinCosine);
}

// The reflectance at normal incidence of a base whose film reflects as much as it does at this angle.
vec3 underFilm(IN(Layers) l, float nDotV, vec3 f0, float f90) {
    vec3 reflectance = filmReflectance(nDotV, l.filmIor, l.filmThickness, f0);
    return mix(f0, f0Through(reflectance, f90, nDotV), l.film);
}

// leastCosine: see leastCosineOver().
Surface surfaceOf(IN(MaterialPoint) m, vec3 toEye, float leastCosine) {
    Surface s;
    s.normal = m.normal;
    s.toEye = toEye;
    s.nDotV = max(dot(s.normal, s.toEye), leastCosine);
    s.diffuse = m.baseColor.rgb * (1.0f - m.metallic);
    s.layers = m.layers;
    if (shades(LAYER_DIFFUSE_TRANSMISSION)) {
        s.diffuse *= 1.0f - s.layers.throughShare;
        s.layers.through *= s.layers.throughShare * (1.0f - m.metallic);
    }
    vec3 dielectricF0 = m.dielectricF0;
    vec3 metalF0 = m.baseColor.rgb;
    if (shades(LAYER_IRIDESCENCE)) {
        dielectricF0 = underFilm(m.layers, s.nDotV, dielectricF0, m.grazing);
        metalF0 = underFilm(m.layers, s.nDotV, metalF0, 1.0f);
    }
    s.roughness = m.roughness;
    float scattering = s.roughness;
    if (shades(LAYER_ANISOTROPY)) {
        vec2 alphas = anisotropicAlphas(s.roughness * s.roughness, s.layers.anisotropy);
        scattering = sqrt(0.5f * (alphas.x + alphas.y));
    }
    vec2 brdf = textureLod(environmentBrdf,
                           environmentBrdfCoordinate(s.nDotV, scattering, kBrdfSize), 0.0f).rg;
    vec3 dielectric = specularEnvironment(dielectricF0, m.grazing, brdf);
    s.reflectance = mix(dielectric, specularEnvironment(metalF0, 1.0f, brdf), m.metallic);
    s.diffuseShare = diffuseWeight(dielectric);
    s.dielectric = vec2(maxComponent(dielectricF0), m.grazing);
    float lobe = max(s.roughness, kMinRoughness);
    float alpha = lobe * lobe;
    s.alphaSquared = alpha * alpha;
    s.masking = sqrt(s.alphaSquared + (1.0f - s.alphaSquared) * s.nDotV * s.nDotV);
    // Bounces are not linear in f0, so each of the two materials that glTF mixes has its own.
    float more = 1.0f / clamp(brdf.x + brdf.y, 0.05f, 1.0f) - 1.0f;
    vec3 dielectricBounces = 1.0f + dielectricF0 * more;
    vec3 metalBounces = 1.0f + metalF0 * more;
    s.f0 = mix(dielectricF0 * dielectricBounces, metalF0 * metalBounces, m.metallic);
    s.f90 = mix(m.grazing * dielectricBounces, metalBounces, m.metallic);
    s.shadowOffset = m.twoSided > 0.5f ? kTwoSidedShadowOffset : kOneSidedShadowOffset;
    s.averages = false;
#if SCATTERS_LIGHTS
    s.bends = false;
    s.between = 0.0f;
    s.inner = false;
#endif
    s.belowSheen = 1.0f;
    s.belowClearcoat = 1.0f;
    if (shades(LAYER_SHEEN)) {
        s.sheenAlbedo = sheenAlbedo(s.nDotV, s.layers.sheenRoughness);
        s.belowSheen = 1.0f - maxComponent(s.layers.sheen) * s.sheenAlbedo;
    }
    if (shades(LAYER_CLEARCOAT)) {
        float c = max(dot(s.layers.clearcoatNormal, toEye), leastCosine);
        vec2 coat = textureLod(environmentBrdf,
                               environmentBrdfCoordinate(c, s.layers.clearcoatRoughness, kBrdfSize),
                               0.0f).rg;
        s.clearcoatReflectance =
            s.layers.clearcoat * specularEnvironment(kClearcoatF0, 1.0f, coat).x;
        s.belowClearcoat = 1.0f - s.clearcoatReflectance;
    }
    return s;
}

#include "include/lobes.glsl"

// For a light with a radius. metres: to it; 0: it has a direction.
Surface facingDisc(IN(Surface) s, float metres, int first) {
    float radius = texelFetch(lightTable, first + 9).x;
    float slope = 0.5f * radius / (metres > 0.0f ? max(metres, radius) : 1.0f);
    return facingCone(s, slope * slope);
}
// evalDirectLight() for a light that may have a radius.
vec3 lightOfDisc(IN(Surface) s, vec3 toLight, float metres, float nDotL, int first) {
    if (viewHas(VIEW_ROUND_LIGHTS)) return evalDirectLight(facingDisc(s, metres, first), toLight, nDotL);
    return evalDirectLight(s, toLight, nDotL);
}

#if SCATTERS_LIGHTS
#include "include/scattering.glsl"
#endif

// Whether light from this direction can contribute: on the side of the eye, through the surface, or
// by a coat with another normal.
bool isLit(float nDotL) {
    return nDotL > 0.0f || shades(LAYER_DIFFUSE_TRANSMISSION | LAYER_CLEARCOAT);
}

// The normal on the side that the light reaches.
vec3 sideOf(IN(Surface) s, float nDotL) {
    return shades(LAYER_DIFFUSE_TRANSMISSION) && nDotL < 0.0f ? -s.normal : s.normal;
}

// Of a directional light whose rows in the table begin at `first`.
vec3 sunLight(IN(Surface) s, vec3 position, int first) {
    vec3 toLight = texelFetch(lightTable, first).xyz;
    float nDotL = dot(s.normal, toLight);
    vec3 power = texelFetch(lightTable, first + 1).rgb;
    if (viewHas(VIEW_SHADOWS)) {
        power *= shadowAt(position, s.shadowOffset * sideOf(s, nDotL), toLight, toLight, 0.0f,
                          first);
    }
#if SCATTERS_LIGHTS
    if (s.inner) power *= lightBeforeFarWall(position, toLight, 0.0f);
#endif
    return power * lightOfDisc(s, toLight, 0.0f, nDotL, first);
}

// The unoccluded irradiance by a punctual light at a surface.
struct ArrivingLight {
    vec3 source;    // position of the light, or its direction
    vec3 toLight;   // unit
    float metres;   // to the light; 0: a direction
    float nDotL;    // normal . toLight
    vec3 power;
    float falloff;  // of power
};

// From any light; one that is not `limited` has neither range nor cone.
ArrivingLight arrivingLight(IN(Surface) s, vec3 position, int first, bool limited) {
    vec4 source = texelFetch(lightTable, first);      // w: 0 for a direction
    vec4 power = texelFetch(lightTable, first + 1);  // w: 1 / range^2, 0 without a range

    vec3 toLight = source.xyz - position * source.w;
    float squared = max(dot(toLight, toLight), 1e-12f);
    float inverse = inversesqrt(squared);
    toLight *= inverse;
    float nDotL = dot(s.normal, toLight);
    float falloff = min(inverse * inverse, 1.0f / kMinLightDistanceSquared);
    if (limited) {
        // spotAttenuation() as a line in the cosine: dot(cone.xyz, toLight) + cone.w, before clamping.
        vec4 cone = texelFetch(lightTable, first + 2);
        float inCone = clamp(dot(cone.xyz, toLight) + cone.w, 0.0f, 1.0f);
        float inRange = min(squared * power.w, 1.0f);  // punctualAttenuation() of the square
        falloff *= inCone * inCone * (1.0f - inRange * inRange);
    }
    return ArrivingLight(source.xyz, toLight, source.w > 0.5f ? sqrt(squared) : 0.0f, nDotL, power.rgb,
                         falloff);
}

vec3 punctualLight(IN(Surface) s, vec3 position, int first, bool limited) {
    ArrivingLight arriving = arrivingLight(s, position, first, limited);
    vec3 sum = vec3(0.0f);
    if (isLit(arriving.nDotL) && arriving.falloff > 0.0f) {
        vec3 light = arriving.power * arriving.falloff;
#if SCATTERS_LIGHTS
        if (s.inner) light *= lightBeforeFarWall(position, arriving.source, arriving.metres);
#endif
        if (viewHas(VIEW_SHADOWS)) {
            light *= shadowAt(position, s.shadowOffset * sideOf(s, arriving.nDotL), arriving.source,
                              arriving.toLight, arriving.metres, first);
        }
        if (!viewHas(VIEW_SHADOWS) || maxComponent(light) > 0.0f) {
#if SCATTERS_LIGHTS
            if (s.bends) {
                sum = light * evalDirectLight(beforeLight(facingDisc(s, arriving.metres, first), arriving.metres),
                                          arriving.toLight, arriving.nDotL);
            } else
#endif
            sum = light * lightOfDisc(s, arriving.toLight, arriving.metres, arriving.nDotL, first);
        }
    }
    return sum;
}

// Light of the lights in the table from number `first` on, at least one. position: of the surface, in
// eye space.
vec3 punctualLights(IN(Surface) s, vec3 position, int first, int count) {
    int row = HARMONIC_ROWS + first * LIGHT_ROWS;
    int end = row + count * LIGHT_ROWS;
    vec3 sum = vec3(0.0f);
    do {
        sum += punctualLight(s, position, row, true);
        row += LIGHT_ROWS;
    } while (row < end);
    return sum;
}

// Prefiltered by roughness: level k of the last holds roughness k / last.
vec3 environmentAlong(vec3 towards, float roughness) {
    return textureLod(environmentMap, towards, roughness * view.environment.x).rgb *
           view.environment.y;
}

// The first lights of the table, without range and cone. count: a constant, so that the loop is
// unrolled; on a software rasteriser a look-up at a constant index takes a third of the time.
vec3 firstPunctualLights(IN(Surface) s, vec3 position, int count) {
    vec3 sum = vec3(0.0f);
    for (int i = 0; i < count; ++i) {
        sum += punctualLight(s, position, HARMONIC_ROWS + i * LIGHT_ROWS, false);
    }
    return sum;
}

// Irradiance / pi of the environment, its intensity folded in. Out of the light table, because each
// number of a uniform block costs a software rasteriser a bounds check in every pixel:
// 6 % of the processor time of Sponza's frame.
vec3 harmonicsAlong(vec3 towards, vec2 bands) {
    vec4 a = texelFetch(lightTable, 0), b = texelFetch(lightTable, 1);
    vec4 c = texelFetch(lightTable, 2), d = texelFetch(lightTable, 3);
    vec4 e = texelFetch(lightTable, 4), f = texelFetch(lightTable, 5);
    vec4 g = texelFetch(lightTable, 6);
    return harmonics9(towards, a.xyz, bands.x * vec3(a.w, b.xy), bands.x * vec3(b.zw, c.x),
                      bands.x * c.yzw, bands.y * d.xyz, bands.y * vec3(d.w, e.xy),
                      bands.y * vec3(e.zw, f.x), bands.y * f.yzw, bands.y * g.xyz);
}
vec3 diffuseAround(IN(Surface) s) {
    if (viewHas(VIEW_SURFACE_LIGHT)) return diffuseFrom(s.light, s.normal);
    return harmonicsAlong(s.normal, vec2(1.0f));
}

// Light in a lobe about `towards`: the visible fraction of the environment, and the light of occluders
// in place of the rest.
vec3 reachingSurface(IN(Surface) s, vec3 towards, vec3 environment) {
    if (viewHas(VIEW_SURFACE_LIGHT)) return gatheredFrom(s.light, towards, environment);
    return environment;
}

// The diffuse part of that, with diffuse transmission.
vec3 diffuseLight(IN(Surface) s) {
    vec3 light = s.diffuse * diffuseAround(s);
    if (shades(LAYER_DIFFUSE_TRANSMISSION)) {
        vec3 behind = viewHas(VIEW_SURFACE_LIGHT) ? s.light.behind
                                                  : harmonicsAlong(-s.normal, vec2(1.0f));
        light += s.layers.through * behind;
    }
    return s.diffuseShare * light;
}

// What a lobe of any shape gathers of the environment. mean: of its directions; spread: of their products
// x y, y z, x z, 3 z z - 1 and x x - y y.
struct LobeSpread {
    vec3 products;
    vec2 squares;
};
LobeSpread spreadAlong(vec3 d, float part) {
    return LobeSpread(part * vec3(d.x * d.y, d.y * d.z, d.x * d.z),
                      part * vec2(3.0f * d.z * d.z - 1.0f, d.x * d.x - d.y * d.y));
}
vec3 harmonicsOfLobe(vec3 mean, LobeSpread spread) {
    vec4 a = texelFetch(lightTable, 0), b = texelFetch(lightTable, 1);
    vec4 c = texelFetch(lightTable, 2), d = texelFetch(lightTable, 3);
    vec4 e = texelFetch(lightTable, 4), f = texelFetch(lightTable, 5);
    vec4 g = texelFetch(lightTable, 6);
    // The coefficients are those of a cosine: two thirds and a quarter of the radiance's.
    vec3 first = vec3(a.w, b.xy) * mean.y + vec3(b.zw, c.x) * mean.z + c.yzw * mean.x;
    vec3 second = d.xyz * spread.products.x + vec3(d.w, e.xy) * spread.products.y +
                  vec3(e.zw, f.x) * spread.squares.x + f.yzw * spread.products.z +
                  g.xyz * spread.squares.y;
    return max(a.xyz + 1.5f * first + 4.0f * second, vec3(0.0f));
}

// Light of the environment that sheen reflects. Its lobe is more a ring about the normal than a lobe about
// its mean direction.
vec3 sheenLight(IN(Surface) s) {
    vec2 axis = sheenAxis(s.nDotV, s.layers.sheenRoughness);
    vec3 side = direction(s.toEye - s.normal * dot(s.toEye, s.normal));
    vec3 mean = side * axis.x + s.normal * axis.y;
    vec2 parts = sheenSpread(axis);
    LobeSpread about = spreadAlong(s.normal, parts.x);
    LobeSpread between = spreadAlong(sqrt(0.5f) * (side + s.normal), parts.y);
    vec3 gathered = harmonicsOfLobe(mean, LobeSpread(about.products + between.products,
                                                     about.squares + between.squares));
    vec3 towards = direction(mean);
    return s.layers.sheen * s.sheenAlbedo * reachingSurface(s, towards, gathered);
}

// Light of the base from its surroundings, dimmed by the layers above it, and that of sheen, without
// the reflection of a coat.
vec3 underCoat(IN(Surface) s, vec3 base) {
    if (shades(LAYER_SHEEN)) base = base * s.belowSheen + sheenLight(s);
    if (shades(LAYER_CLEARCOAT)) base *= s.belowClearcoat;
    return base;
}

// What specular lobes and layers reflect of emissive surfaces: they are one light in their mean direction.
// A cone of half angle t has a mean of directions of length r = (1 + cos t) / 2, and tan(t / 2)^2 is
// (1 - r) / r.
vec3 emittersLight(IN(Surface) s) {
    vec3 sum = vec3(0.0f);
    if (viewHas(VIEW_EMITTERS)) {
        float gathered = length(s.light.emittedFlux);
        float light = luminance(s.light.emitted);
        float r = clamp(gathered / max(light, 1e-20f), 0.25f, 1.0f);
        vec3 toLight = s.light.emittedFlux / max(gathered, 1e-20f);
        float nDotL = dot(s.normal, toLight);
        if (nDotL > 0.0f && light > 0.0f) {
            Surface wide = widened(s, (1.0f - r) / r);
            wide.diffuse = vec3(0.0f);
            wide.layers.through = vec3(0.0f);
            sum = kPi * r * s.light.emitted * evalDirectLight(wide, toLight, nDotL);
        }
    }
    return sum;
}

RoundLobe lobeOfCoat(IN(Surface) s) {
    vec3 n = s.layers.clearcoatNormal;
    float roughness = s.layers.clearcoatRoughness;
    return roundLobe(n, s.toEye, max(dot(n, s.toEye), kMinCosine), roughness * roughness);
}

// Radiance of the surface due to the light of its surroundings. mirrored: the radiance in its specular
// lobe, from the environment or from a picture of the scene (reflection.glsl). A coat shows the
// environment.
vec3 environmentLight(IN(Surface) s, vec3 mirrored) {
    vec3 light = underCoat(s, s.reflectance * mirrored + diffuseLight(s));
    if (shades(LAYER_CLEARCOAT)) {
        RoundLobe lobe = lobeOfCoat(s);
        vec3 around = environmentAlong(lobe.along, sqrt(lobe.alpha));
        light += s.clearcoatReflectance * reachingSurface(s, lobe.along, around);
    }
    return light;
}
