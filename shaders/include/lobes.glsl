// The lobes of a surface: the factor from light of one direction to radiance towards the eye, at a point, and
// averaged over the half vectors that a pixel or a wide light covers. A part of lighting.glsl, after Surface.

// The surface with highlights averaged over all half vectors of a parallelogram of slopes with edges x
// and y: an ellipse of that area and covariance. If it is far wider than alpha, the mean of the lobe is
// uniform within it, so distances are measured in its axes; if it is far smaller they are unchanged;
// in between they are measured in the axes of the sum of both covariances.
Covered coveredAbout(vec3 normal, float alphaSquared, vec3 x, vec3 y) {
    const float kRoot = 0.5641896f;  // 1 / sqrt(pi)
    Covered c;
    c.x = kRoot * (x - normal * dot(normal, x));
    c.y = kRoot * (y - normal * dot(normal, y));
    c.area = length(cross(c.x, c.y));
    c.trace = alphaSquared + dot(c.x, c.x) + dot(c.y, c.y);
    float both = alphaSquared + c.area;
    float determinant = alphaSquared * c.trace + c.area * c.area;
    c.scale = both / determinant;
    c.weight = both * inversesqrt(determinant);
    return c;
}
// The density in the middle of such a mean, which is nowhere denser.
float densestMean(vec3 normal, float alphaSquared, vec3 x, vec3 y) {
    Covered c = coveredAbout(normal, alphaSquared, x, y);
    return inversesqrt(alphaSquared * c.trace + c.area * c.area) / kPi;
}

float clearcoatAlpha(IN(Layers) l) {
    float roughness = max(l.clearcoatRoughness, kMinRoughness);
    return roughness * roughness;
}
// turn, ofCoat: parallelograms of slopes, of the surface and of a clear coat.
Surface covering(IN(Surface) narrow, IN(Turn) turn, IN(Turn) ofCoat) {
    Surface s = narrow;
    s.averages = true;
    s.covered = coveredAbout(s.normal, s.alphaSquared, turn.steadyX, turn.steadyY);
    s.densest = densestMean(s.normal, s.alphaSquared, turn.wholeX, turn.wholeY);
    if (shades(LAYER_CLEARCOAT)) {
        float alpha = clearcoatAlpha(s.layers);
        vec3 n = s.layers.clearcoatNormal;
        s.clearcoatCovered = coveredAbout(n, alpha * alpha, ofCoat.steadyX, ofCoat.steadyY);
        s.clearcoatDensest = densestMean(n, alpha * alpha, ofCoat.wholeX, ofCoat.wholeY);
    }
    return s;
}

// ggxDistribution() * ggxVisibility() of optics.glsl as one quotient, times the cosine to the light.
// Terms that all lights share are computed before: compilers for processors do not hoist them.
// halfway need not be unit; perSquare: 1 over the square of its length.
float ggxLobe(IN(Surface) s, vec3 halfway, float perSquare, float nDotL) {
    float a2 = s.alphaSquared;
    float nDotH = dot(s.normal, halfway);
    vec3 across = cross(s.normal, halfway);
    float q = max((nDotH * nDotH * a2 + dot(across, across)) * perSquare, 1e-9f);
    float l = max(nDotL, kMinCosine);
    float smith = s.nDotV * sqrt(a2 + (1.0f - a2) * l * l) + l * s.masking;
    return (0.5f / kPi) * a2 * max(nDotL, 0.0f) / (q * q * smith);
}

// The mean of that over the covered half vectors. If they spread far wider than the lobe, only points
// whose normal is close to the half vector contribute, so masking and cosine are taken at those.
// densest: a bound of it.
float ggxMeanLobe(IN(Covered) c, float densest, vec3 normal, float a2, float nDotV, vec3 halfway,
                  float perSquare, float nDotL, float eyeDotH) {
    float nDotH = dot(normal, halfway);
    vec3 across = cross(normal, halfway);
    float alongX = dot(c.x, halfway);
    float alongY = dot(c.y, halfway);
    float distance2 =
        c.scale * (c.trace * dot(across, across) - alongX * alongX - alongY * alongY);
    float density = c.weight * ggxMeanDistribution(nDotH * nDotH * perSquare,
                                                   max(distance2, 0.0f) * perSquare, a2, c.area);
    density = min(density, densest);
    float part = c.area / (c.area + a2);
    float cosine = mix(nDotL, eyeDotH, part);
    float visible = ggxVisibility(cosine, mix(nDotV, eyeDotH, part), sqrt(a2));
    return nDotL > 0.0f ? density * visible * cosine : 0.0f;
}

float grainLobe(IN(Surface) s, vec3 toLight, vec3 halfway, float nDotL) {
    vec3 across = cross(s.normal, s.layers.grain);
    vec3 h = direction(halfway);
    return ggxAnisotropicLobe(
        vec3(dot(toLight, s.layers.grain), dot(toLight, across), nDotL),
        vec3(dot(s.toEye, s.layers.grain), dot(s.toEye, across), s.nDotV),
        vec3(dot(h, s.layers.grain), dot(h, across), dot(h, s.normal)),
        anisotropicAlphas(sqrt(s.alphaSquared), s.layers.anisotropy));
}

float clearcoatLobe(IN(Surface) s, vec3 toLight, vec3 halfway, float eyeDotH) {
    vec3 n = s.layers.clearcoatNormal;
    float nDotL = dot(n, toLight);
    float alpha = clearcoatAlpha(s.layers);
    float fresnel = kClearcoatF0.x + (1.0f - kClearcoatF0.x) * pow5(1.0f - eyeDotH);
    float perSquare = 1.0f / max(dot(halfway, halfway), 1e-12f);
    if (s.averages) {
        float nDotV = max(dot(n, s.toEye), kMinCosine);
        return s.layers.clearcoat * fresnel *
               ggxMeanLobe(s.clearcoatCovered, s.clearcoatDensest, n, alpha * alpha, nDotV, halfway,
                           perSquare, nDotL, eyeDotH);
    }
    vec3 across = cross(n, halfway);
    float density = ggxDistribution(dot(n, halfway) * sqrt(perSquare), dot(across, across) * perSquare,
                                    alpha);
    return nDotL > 0.0f ? s.layers.clearcoat * fresnel * density * nDotL *
                              ggxVisibility(nDotL, dot(n, s.toEye), alpha)
                        : 0.0f;
}

// Factor from light arriving along toLight (unit) to radiance towards the eye; nDotL: normal . toLight.
vec3 evalBaseLight(IN(Surface) s, vec3 toLight, float nDotL) {
    vec3 halfway = toLight + s.toEye;
    float perLength = inversesqrt(max(dot(halfway, halfway), 1e-12f));
    float perSquare = perLength * perLength;
    float eyeDotH = dot(s.toEye, halfway) * perLength;
    vec3 fresnel = fresnelSchlick(s.f0, s.f90, eyeDotH);
    float below = 1.0f - (s.dielectric.x + (s.dielectric.y - s.dielectric.x) * pow5(1.0f - eyeDotH));
    float lobe = s.averages ? ggxMeanLobe(s.covered, s.densest, s.normal, s.alphaSquared, s.nDotV,
                                          halfway, perSquare, nDotL, eyeDotH)
                            : ggxLobe(s, halfway, perSquare, nDotL);
    if (shades(LAYER_ANISOTROPY)) {
        lobe = s.layers.anisotropy > 0.0f ? grainLobe(s, toLight, halfway, nDotL) : lobe;
    }
#if SCATTERS_LIGHTS
    if (s.bends) {  // facets bend light less than in proportion to their slope
        float nDotH = dot(s.normal, halfway) * perLength;
        float turn = max(2.0f * nDotH * nDotH - 1.0f, 0.0f);
        lobe *= turn * turn;
    }
#endif
    return fresnel * lobe +
           max(nDotL, 0.0f) * below * (1.0f / kPi) * s.diffuse;
}

vec3 evalDirectLight(IN(Surface) s, vec3 toLight, float nDotL) {
    vec3 sum = evalBaseLight(s, toLight, nDotL);
    if (shades(LAYER_DIFFUSE_TRANSMISSION)) {
        sum += max(-nDotL, 0.0f) * s.diffuseShare * (1.0f / kPi) * s.layers.through;
    }
    if (shades(LAYER_SHEEN | LAYER_CLEARCOAT)) {
        vec3 halfway = toLight + s.toEye;
        vec3 h = direction(halfway);
        if (shades(LAYER_SHEEN)) {
            float lobe = sheenLobe(nDotL, s.nDotV, dot(s.normal, h), s.layers.sheenRoughness);
            sum = sum * s.belowSheen + s.layers.sheen * lobe;
        }
        if (shades(LAYER_CLEARCOAT)) {
            sum = sum * s.belowClearcoat +
                  vec3(clearcoatLobe(s, toLight, halfway, dot(s.toEye, h)));
        }
    }
    return sum;
}

// An ellipse with the covariance of another one and of a disc of slopes with the squared radius `extent`.
Covered withDisc(IN(Covered) narrow, float alphaSquared, float extent) {
    Covered c = narrow;
    float trace = c.trace + 2.0f * extent;
    c.area = sqrt(c.area * c.area + extent * (c.trace - alphaSquared) + extent * extent);
    float both = alphaSquared + c.area;
    float determinant = alphaSquared * trace + c.area * c.area;
    c.scale = both / determinant;
    c.weight = both * inversesqrt(determinant);
    c.trace += extent;  // the disc's part of the slopes along x and y is subtracted already
    return c;
}
Covered nothingCovered(float alphaSquared) {
    return Covered(vec3(0.0f), vec3(0.0f), 0.0f, alphaSquared, 1.0f, 1.0f);
}

// The surface for light from a cone of half angle t, whose half vectors are a disc of slopes with the
// squared radius `extent`, tan(t / 2)^2. No change for 0.
//
// For a light that fills the cone: the highlight is averaged over the disc, as over what a pixel covers.
Surface facingCone(IN(Surface) s, float extent) {
    Surface wide = s;
    if (extent > 0.0f) {
        Covered pixel = nothingCovered(s.alphaSquared);
        if (s.averages) pixel = s.covered;
        wide.covered = withDisc(pixel, s.alphaSquared, extent);
        wide.densest = 1.0f / (kPi * (s.alphaSquared + extent));
        if (s.averages) wide.densest = min(wide.densest, s.densest);
        if (shades(LAYER_CLEARCOAT)) {
            float alpha = clearcoatAlpha(s.layers);
            Covered ofCoat = nothingCovered(alpha * alpha);
            if (s.averages) ofCoat = s.clearcoatCovered;
            wide.clearcoatCovered = withDisc(ofCoat, alpha * alpha, extent);
            wide.clearcoatDensest = 1.0f / (kPi * (alpha * alpha + extent));
            if (s.averages) wide.clearcoatDensest = min(wide.clearcoatDensest, s.clearcoatDensest);
        }
        wide.averages = true;
        if (shades(LAYER_ANISOTROPY)) {  // its lobe has no mean; see grainLobe()
            bool grain = s.layers.anisotropy > 0.0f;
            wide.alphaSquared = grain ? min(s.alphaSquared + extent, 1.0f) : s.alphaSquared;
        }
    }
    return wide;
}
// For light that comes from about there: a wider lobe, without the edge of a disc. In the middle of a disc
// the mean of the GGX lobe has the density of one whose squared alpha is greater by `extent`. Slopes that a
// pixel covers are added as such a disc.
Surface widened(IN(Surface) s, float extent) {
    Surface wide = s;
    if (extent > 0.0f) {
        wide.averages = false;
        wide.alphaSquared =
            min(s.alphaSquared + extent + (s.averages ? s.covered.area : 0.0f), 1.0f);
        wide.masking = sqrt(wide.alphaSquared + (1.0f - wide.alphaSquared) * s.nDotV * s.nDotV);
        if (shades(LAYER_CLEARCOAT)) {
            float alpha = clearcoatAlpha(s.layers);
            float area = s.averages ? s.clearcoatCovered.area : 0.0f;
            wide.layers.clearcoatRoughness = pow(min(alpha * alpha + extent + area, 1.0f), 0.25f);
        }
    }
    return wide;
}
