// Reflection and refraction of transparent bodies: interfaces from both sides, panes, solids,
// absorption, rough glass. Needs optics.glsl before it. Compiled as GLSL 4.30 and as C++ (see
// optics.glsl).
//
// Radiance is measured in air, at the eye and in the backdrop, so no factor eta^2 appears (erratum G2).
// `ior`: index inside a body / index around it. `eta`: index behind an interface / in front of it.
#ifndef CLERESTORY_GLASS_GLSL
#define CLERESTORY_GLASS_GLSL

// Indices nearer to 1 than this do not refract (fresnelDielectric() has the same limit).
const float kNoInterface = 1e-6f;

// ---- one interface -----------------------------------------------------------------------------

// An interface that a ray hits.
struct Interface {
    vec3 normal;  // against the ray
    float eta;
};

// normal: of the body's surface, outwards. The ray may come from either side (erratum G5).
Interface interfaceMet(vec3 incident, vec3 normal, float ior) {
    float index = clamp(ior, 1e-3f, 1e3f);
    bool fromInside = dot(incident, normal) > 0.0f;
    Interface met;
    met.normal = fromInside ? -normal : normal;
    met.eta = fromInside ? 1.0f / index : index;
    return met;
}

struct Refraction {
    vec3 direction;  // unit; the mirrored one where nothing gets through
    float cosine;    // of the ray behind the interface and its normal; 0 where nothing gets through
    bool total;      // total internal reflection: the whole light follows `direction`
};

// Snell's law as a vector. normal: against the ray. `total` is set exactly where fresnelDielectric()
// returns 1 for total internal reflection.
Refraction refracted(vec3 incident, vec3 normal, float eta) {
    float e = clamp(eta, 1e-3f, 1e3f);
    float c = clamp(-dot(incident, normal), 0.0f, 1.0f);
    Refraction result;
    result.direction = incident;
    result.cosine = c;
    result.total = false;
    if (abs(e - 1.0f) < kNoInterface) {
        return result;  // also at grazing, where two limits meet
    }
    float g2 = (e - 1.0f) * (e + 1.0f) + c * c;  // (eta cosine)^2
    // The part along the interface is what Snell's law divides by eta. Taken from the vectors, it
    // keeps its digits near normal incidence, where 1 - c^2 has none.
    vec3 along = incident + normal * c;
    if (g2 <= 0.0f) {
        result.direction = along + normal * c;
        result.cosine = 0.0f;
        result.total = true;
        return result;
    }
    result.cosine = min(sqrt(g2) / e, 1.0f);
    // Unit as it is, but for rounding at indices that no glass has.
    result.direction = normalize(along / e - normal * result.cosine);
    return result;
}

// Into or out of a body, whichever side the ray comes from. normal: outwards.
Refraction refractedAtSurface(vec3 incident, vec3 normal, float ior) {
    Interface met = interfaceMet(incident, normal, ior);
    return refracted(incident, met.normal, met.eta);
}

// Out of a body whose back normal is known only roughly (interpolated, from a picture): whatever
// side it points to, the ray leaves.
Refraction refractedOut(vec3 inside, vec3 backNormal, float ior) {
    vec3 against = dot(inside, backNormal) > 0.0f ? -backNormal : backNormal;
    return refracted(inside, against, 1.0f / clamp(ior, 1e-3f, 1e3f));
}

// Reflectance of an interface. specular: weight of the body's reflections, 0..1; not applied to total
// internal reflection, where no light can be transmitted. eta, cosTheta: as fresnelDielectric().
float fresnelOfBody(float cosTheta, float eta, float specular) {
    float c = clamp(cosTheta, 0.0f, 1.0f);
    float e = clamp(eta, 1e-3f, 1e3f);
    bool total = (e - 1.0f) * (e + 1.0f) + c * c <= 0.0f && abs(e - 1.0f) >= kNoInterface;
    return fresnelDielectric(cosTheta, eta) * (total ? 1.0f : specular);
}

// ---- absorption --------------------------------------------------------------------------------

float absorbedChannel(float color, float ratio) {
    if (color <= 0.0f) {
        return ratio > 0.0f ? 0.0f : 1.0f;
    }
    return exp2(log2(min(color, 1.0f)) * ratio);
}

// Transmittance of a path (metres) through a medium: color^(path / distance), per channel
// (Beer-Lambert with the parameters of KHR_materials_volume). Distance 0 or infinite: no absorption.
vec3 absorption(vec3 color, float attenuationDistance, float path) {
    float ratio = 0.0f;
    if (attenuationDistance > 0.0f && path > 0.0f) {
        // The limits apply only where every colour but white is absorbed; they keep 1e18 / 1e-38 finite.
        ratio = min(min(path, 1e18f) / max(attenuationDistance, 1e-18f), 1e6f);
    }
    return vec3(absorbedChannel(color.x, ratio), absorbedChannel(color.y, ratio),
                absorbedChannel(color.z, ratio));
}

// ---- shares of light ---------------------------------------------------------------------------

// Shares of the light from the mirrored direction and from behind; their sum is 1 when nothing is
// absorbed (erratum G4).
struct GlassShares {
    vec3 reflected;
    vec3 transmitted;
};

// A pane with all bounces between its faces (erratum G3). fresnel: of one face from outside;
// clear: absorption() along one crossing. One Fresnel coefficient represents both polarisations, as in a
// path tracer without polarisation: at most 0.0222 from the polarised truth
// (at 74 degrees, ior 1.5).
GlassShares paneShares(float fresnel, vec3 clear) {
    float f = clamp(fresnel, 0.0f, 1.0f);
    vec3 a = clamp(clear, 0.0f, 1.0f);
    // 1 - f^2 a^2 without cancellation; 0 only where f is 1, and then the dividend is 0, too.
    vec3 divisor = ((1.0f - f) + f * (vec3(1.0f) - a)) * (vec3(1.0f) + f * a);
    GlassShares shares;
    shares.transmitted = (1.0f - f) * (1.0f - f) * a / max(divisor, vec3(1e-20f));
    shares.reflected = f * (vec3(1.0f) + a * shares.transmitted);
    return shares;
}

// A solid. Light that is reflected inside leaves elsewhere, and is counted as if it left with the
// refracted light. clear: transmittance along one chord.
GlassShares solidShares(float fresnel, vec3 clear) {
    float f = clamp(fresnel, 0.0f, 1.0f);
    vec3 a = clamp(clear, 0.0f, 1.0f);
    vec3 divisor = (1.0f - f) + f * (vec3(1.0f) - a);  // 1 - f a
    GlassShares shares;
    shares.transmitted = (1.0f - f) * (1.0f - f) * a / max(divisor, vec3(1e-20f));
    shares.reflected = vec3(f);
    return shares;
}

// Only the dielectric part of a surface transmits light (KHR_materials_transmission). The fraction of
// a surface that transmits, and the metallic value of the rest: all of the metal, and the part of the
// dielectric that does not transmit.
float clearShare(float transmission, float metallic) {
    return clamp(transmission, 0.0f, 1.0f) * (1.0f - clamp(metallic, 0.0f, 1.0f));
}
float metallicBesideGlass(float transmission, float metallic) {
    float m = clamp(metallic, 0.0f, 1.0f);
    // Without a rest the result has weight 0.
    return m / max(1.0f - clearShare(transmission, m), 1e-6f);
}

// ---- ways through ------------------------------------------------------------------------------

// A ray's way through a body, from where it enters to where it leaves.
struct Crossing {
    vec3 inside;     // unit, within the body
    vec3 offset;     // from entry to exit, metres
    float path;      // length of the offset
    vec3 direction;  // unit, behind the body
    bool total;      // no light enters: `direction` is the mirrored one, the path is 0
};

// Between two parallel faces `thickness` metres apart: the direction is unchanged. normal: against the
// ray.
Crossing throughPane(vec3 incident, vec3 normal, float ior, float thickness) {
    Refraction entry = refracted(incident, normal, ior);
    Crossing crossing;
    crossing.inside = entry.direction;
    crossing.total = entry.total;
    // The clamp matters only for an index of 1 at grazing.
    crossing.path = entry.total ? 0.0f : max(thickness, 0.0f) / max(entry.cosine, kMinCosine);
    crossing.offset = entry.direction * crossing.path;
    crossing.direction = entry.total ? entry.direction : incident;
    return crossing;
}

// Lateral displacement of a ray by a pane, metres perpendicular to the ray (erratum G3).
float paneShift(float cosTheta, float ior, float thickness) {
    float c = clamp(cosTheta, 0.0f, 1.0f);
    float e = clamp(ior, 1e-3f, 1e3f);
    float g2 = (e - 1.0f) * (e + 1.0f) + c * c;
    if (abs(e - 1.0f) < kNoInterface || g2 <= 0.0f) {
        return 0.0f;
    }
    return thickness * sqrt((1.0f - c) * (1.0f + c)) * (1.0f - c / sqrt(g2));
}

// From the point where a ray hits a pane to the point where the line of the leaving ray crosses the
// same face.
vec3 asideInPane(vec3 incident, vec3 normal, Crossing way, float thickness) {
    float straight = max(thickness, 0.0f) / max(-dot(incident, normal), 1e-3f);
    return way.total ? vec3(0.0f) : way.offset - incident * straight;
}

// Through a ball of diameter `thickness` that the surface is a part of: exact for balls, an inexpensive
// approximation for other solids. normal: against the ray, at the entry. The second angle equals the first
// (the triangle of centre, entry and exit has two equal sides), so a ray that enters also leaves.
Crossing throughBall(vec3 incident, vec3 normal, float ior, float thickness) {
    Refraction entry = refracted(incident, normal, ior);
    Crossing crossing;
    crossing.inside = entry.direction;
    crossing.total = entry.total;
    crossing.path = entry.total ? 0.0f : max(thickness, 0.0f) * entry.cosine;
    crossing.offset = entry.direction * crossing.path;
    crossing.direction = entry.direction;
    float e = clamp(ior, 1e-3f, 1e3f);
    if (!entry.total && abs(e - 1.0f) >= kNoInterface) {
        // At the exit, against the ray: 2 (n.r) r - n.
        vec3 exitNormal = -2.0f * entry.cosine * entry.direction - normal;
        float c = clamp(-dot(incident, normal), 0.0f, 1.0f);
        crossing.direction =
            normalize(e * (entry.direction + exitNormal * entry.cosine) - exitNormal * c);
    }
    return crossing;
}

// The thickness of a solid is known along its normal, but not the shape of its far side. If the
// thickness is the diameter of the ball that fits the near side, the far side is that of the ball. If
// it is a small fraction of it, the body is a wall with nearly parallel sides: a vase, a box, a window
// with round edges. Returns the weight of the ball, 0..1. curvature: of the near side, 1 / metres.
float ballShare(float thickness, float curvature) {
    float diameters = 0.5f * max(thickness, 0.0f) * max(curvature, 0.0f);
    return smoothstep(0.25f, 0.75f, min(diameters, 1.0f));
}

// Interpolates from the path through a wall to the path through a ball.
Crossing crossingBetween(Crossing pane, Crossing ball, float share) {
    Crossing crossing = ball;
    crossing.path = mix(pane.path, ball.path, share);
    crossing.offset = mix(pane.offset, ball.offset, share);
    // Less than a right angle apart, so that the sum has a length; the fallback is for rounding.
    vec3 sum = mix(pane.direction, ball.direction, share);
    crossing.direction = dot(sum, sum) > 1e-6f ? normalize(sum) : ball.direction;
    return crossing;
}

// ---- rough glass -------------------------------------------------------------------------------

// Slope of the cone in which light leaves rough glass, per unit slope of a mirror's normals; to
// compare: a mirror's is 2 alpha. Derived: a facet tilted by d turns a ray that leaves by
// (g - c) d across the plane of incidence and by (g - c) d / c in it, with c the cosine outside and
// g = eta cosine inside; their geometric mean covers the same solid angle. Two rough faces with
// independent facets: the peak of GGX slopes convolved with themselves is a third as high, hence
// sqrt(3). Index 1 leaves the picture sharp at any roughness.
float glassSpread(float alpha, float cosTheta, float ior) {
    float c = clamp(cosTheta, 0.05f, 1.0f);  // below: a mirror, and no cone
    float e = clamp(ior, 1e-3f, 1e3f);
    float e2MinusOne = (e - 1.0f) * (e + 1.0f);
    float g = sqrt(max(e2MinusOne + c * c, 0.0f));
    return 1.7320508f * clamp(alpha, 0.0f, 1.0f) * abs(e2MinusOne / (g + c)) * inversesqrt(c);
}
// The slope of one rough face in that of two.
const float kOneOfTwoFaces = 0.57735027f;

#endif
