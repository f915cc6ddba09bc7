// Radiance along a ray through the scene. Smooth mirrors and glass continue the path, other surfaces
// are shaded as they would be in a pixel, and rays that leave the scene see the environment.
// After lighting.glsl, glass.glsl and hit.glsl. Compiled as GLSL and as C++ (renderer/rays/shader_code.h).

// A surface that mirrors the scene (scene/classification.h) continues rays if it is smoother than
// kTracedRoughness and reflects more than kMinMirrored of the ray's light; otherwise it reflects the
// environment.
const float kTracedRoughness = 0.3f;
const float kMinMirrored = 0.05f;
// Flat: the normal turns by less than this, radians, over the ray's length.
const float kFlatEnough = 1e-3f;
// Of a reflection, what crossing a face of glass counts, and a reflection inside it at a flat face. Vessels
// that hold a liquid have many faces, and the light hardly falls from one to the next. After reflections at
// curved faces neighbouring paths have nothing in common, and one of them does not show their mean.
const float kTurnOfGlass = 1.0f / 3.0f;
// Least share of a reflection at a flat face of glass that is followed besides the path behind the face.
const float kMinSplit = 0.1f;
// Holes of masks that a path may pass.
const int kMaxHoles = 12;

// Slope of a pixel's cone above which the environment is averaged over the cone.
const float kWidePixel = 0.5f;

vec3 environmentAtEnd(vec3 along, RayCone cone) {
    // Half the slope of a cone is the alpha of a mirror with such a lobe. A pixel's footprint is uniform, without
    // tails, and matters only where it is wide: after glass and repeated reflections in small round objects.
    float alpha = 0.5f * cone.lobe + 0.25f * max(abs(cone.pixel) - kWidePixel, 0.0f);
    return environmentAlong(along, min(sqrt(alpha), 1.0f));
}

// The same for a path without a reflection, if `direct`: it ends at the background of the request.
vec3 backgroundAtEnd(vec3 along, RayCone cone, bool direct) {
    return direct && tracing.background.w > 0.0f ? tracing.background.xyz
                                                 : environmentAtEnd(along, cone);
}

// Of a path that ends at a mirror or glass, or that is not followed: the light that reaches the surface.
vec3 surroundingsAtEnd(IN(HitPoint) p, vec3 along, RayCone cone, bool direct) {
    vec3 open = backgroundAtEnd(along, cone, direct);
    if (viewHas(VIEW_SURFACE_LIGHT)) return gatheredFrom(p.light, along, open);
    return open;
}

// How far half vectors turn to each side over a cone: as far as the normal does along d over its width, and
// by half of its spread. cosine: of the angle at which the cone meets the surface in this direction. At an
// angle it covers more of the surface, but no more than the rest of a ball where the surface curves away.
// Wider cones cover more than this surface.
const float kMaxTurned = 0.84f;
vec3 turnOverCone(IN(HitPoint) p, RayCone cone, vec3 d, float cosine) {
    vec3 change = changeAlong(p.change, d) * cone.width;
    float across = length(change);
    change /= max(max(cosine, sqrt(0.5f * across)), 1e-6f);
    // A hollow surface may turn against the spread of a cone, but not against that of a lobe.
    vec3 turn = (dot(change, d) < 0.0f ? -change : change) + d * (0.5f * (abs(cone.pixel) + cone.lobe));
    const float kEdge = 0.8862269f;  // of a square as large as a disc, over its diameter
    return turn * (kEdge * min(kMaxTurned / max(length(turn), 1e-6f), 1.0f));
}

// The surface for a cone that hits it.
Surface coveredByCone(IN(Surface) s, IN(HitPoint) p, RayCone cone) {
    vec3 side = cross(s.normal, s.toEye);
    side = dot(side, side) > kNoDirection ? direction(side) : frameAbout(s.normal)[0];
    vec3 x = turnOverCone(p, cone, cross(side, s.normal), s.nDotV);
    vec3 y = turnOverCone(p, cone, side, 1.0f);
    return covering(s, widened(p.turn, x, y), widened(p.clearcoatTurn, x, y));
}

vec3 punctualLightAtHit(IN(HitPoint) p, IN(Surface) s) {
    if (!hitHas(FEATURE_LIGHTS)) return vec3(0.0f);
    vec3 punctual = punctualLights(s, eyeAxes(p.position - tracing.eye.xyz), p.firstLight, p.lights);
    return p.lights > 0 ? punctual : vec3(0.0f);
}

// A reflection at glass that is followed when the path behind the glass has ended.
struct Branch {
    vec3 start;
    vec3 along;
    vec3 weight;  // 0: there is none
    RayCone cone;
    float turns;
};
const Branch kNoBranch = Branch(vec3(0.0f), vec3(0.0f), vec3(0.0f), RayCone(0.0f, 0.0f, 0.0f), 0.0f);

// start: relative to the hierarchy's origin, off the surface that the ray leaves. along: unit, in
// eye space's axes. share: of the result in its pixel; the path ends when its share falls below the
// least share of the plan. direct: the path has no reflection so far.
vec3 tracedRadiance(vec3 start, vec3 along, RayCone cone, float share, bool direct) {
    vec3 sum = vec3(0.0f);
    vec3 weight = vec3(1.0f);
    float turns = tracing.limits.x;
    int holes = kMaxHoles;
    Branch branch = kNoBranch;
    bool going = true;
    do {
        if (!going) {
            start = branch.start;
            along = branch.along;
            weight = branch.weight;
            cone = branch.cone;
            turns = branch.turns;
            direct = false;
            branch.weight = vec3(0.0f);
        }
        Hit hit = traceClosest(start, worldAxes(along), 0.0f, 1e30f);
        if (hit.triangle < 0) {
            noteHit(-1);
            sum += weight * backgroundAtEnd(along, cone, direct);
            going = false;
            continue;
        }
        float travelled = hit.distance;
        cone = coneAfter(cone, travelled);
        HitPoint p = hitPoint(hit, along, cone.width);
        MaterialPoint m = p.material;
        if (viewHas(VIEW_SURFACE_LIGHT)) m.occlusion = 1.0f;  // light at vertices has the occlusion

        // As for pixels: holes of alpha masks, and the back of one-sided surfaces, are not drawn.
        bool back = !p.front && (p.flags & (TRACE_DOUBLE_SIDED | TRACE_SOLID)) == 0;
        bool hole = holes > 0 && (m.baseColor.a < p.cutoff || back);
        bool there = !hole;
        bool unlit = hitHas(FEATURE_UNLIT) && (p.flags & TRACE_UNLIT) != 0;
        float coverage = 1.0f;
        if (hitHas(FEATURE_BLEND)) {
            bool blends = holes > 0 && (p.flags & TRACE_BLEND) != 0;
            coverage = blends ? clamp(m.baseColor.a, 0.0f, 1.0f) : 1.0f;
        }
        bool solid = false;
        bool pane = false;
        float clarity = 0.0f;  // fraction that transmits light
        float dull = 1.0f;     // of the dielectric part
        if (hitHas(FEATURE_GLASS)) {
            bool glass = there && p.glass.x > 0.0f;
            solid = glass && (p.flags & TRACE_SOLID) != 0;
            pane = glass && (p.flags & TRACE_PANE) != 0;
            dull = solid || pane ? 1.0f - clamp(p.glass.x, 0.0f, 1.0f) : 1.0f;
            clarity = solid || pane ? clearShare(p.glass.x, m.metallic) : 0.0f;
            if (solid && !p.front) clarity = 1.0f;  // the exit from a body that the ray has entered
        }
        bool veil = there && coverage < 1.0f && !solid && !pane;
        bool leaves = solid && !p.front;  // a pane has no inside
        bool mirror = false;
        vec3 reflectance = vec3(0.0f);
        noteHit(p.instance);

        // Radiance of the surface itself along the ray, without the light that the path continues for.
        vec3 own = unlit ? m.baseColor.rgb : vec3(0.0f);
        if (there && !leaves && !unlit) {
            float across = dot(p.faceNormal, along);
            float least = leastCosineOver(across * across);
            Surface s = surfaceOf(m, -along, least);
            s.light = p.light;
            if (hitLayered(LAYER_CLEARCOAT)) m.emitted *= s.belowClearcoat;
            reflectance = s.belowSheen * s.belowClearcoat * s.reflectance;
            bool level = p.curvature * hit.distance < kFlatEnough;
            mirror = !solid && !pane && !veil &&
                     (p.flags & (level ? TRACE_MIRROR_FLAT : TRACE_MIRROR_CURVED)) != 0 &&
                     m.roughness <= kTracedRoughness &&
                     maxComponent(weight * reflectance) > kMinMirrored;
            if (clarity < 1.0f) {
                vec3 around = vec3(0.0f);
                if (!mirror) {
                    RoundLobe lobe = roundLobe(s.normal, s.toEye, s.nDotV, s.roughness * s.roughness);
                    around = reachingSurface(s, lobe.along, environmentAlong(lobe.along, sqrt(lobe.alpha)));
                }
                if (solid || pane) {
                    m.metallic = metallicBesideGlass(p.glass.x, m.metallic);
                    Surface unclear = surfaceOf(m, -along, least);
                    unclear.light = p.light;
                    own = (1.0f - clarity) * environmentLight(unclear, around);
                } else {
                    own = environmentLight(s, around) * m.occlusion;
                    if (!mirror) own += emittersLight(s);
                }
            }
            if (hitHas(FEATURE_LIGHTS)) {
                s.diffuse *= dull;
                own += punctualLightAtHit(p, coveredByCone(s, p, cone));
            }
        }
        if (there) sum += weight * (coverage * own + m.emitted);

        vec3 normal = dot(m.normal, along) < 0.0f ? m.normal : p.faceNormal;
        float alpha = m.roughness * m.roughness;
        vec3 next = along;
        vec3 aside = vec3(0.0f);
        bool crosses = true;  // the path continues behind the face
        if (solid || pane) {
            vec3 facet = facetAt(normal, along, alpha);
            vec3 met = solid ? facet : normal;
            float c = -dot(along, met);
            float eta = leaves ? 1.0f / p.glass.y : p.glass.y;
            float fresnel = fresnelOfBody(c, eta, m.specular);
            vec3 mirrored = mirroredAt(along, facet, p.faceNormal);
            Refraction bent = refracted(along, met, eta);
            Crossing way = throughPane(along, normal, p.glass.y, p.glass.z);
            vec3 clear = absorption(p.attenuation, p.glass.w, pane ? way.path : travelled);
            GlassShares shares = paneShares(fresnel, clear);
            if (solid) {
                weight *= p.front ? vec3(1.0f) : clear;  // of the way inside
                shares.reflected = vec3(fresnel);
                shares.transmitted = vec3(1.0f - fresnel);
                crosses = !bent.total && fresnel <= 0.5f;
                next = crosses ? bent.direction : mirrored;
            }
            float spread = glassSpread(alpha, c, p.glass.y);
            if (pane) {
                aside = asideInPane(along, normal, way, p.glass.z);
                next = beyondPane(along, spread);
            }
            // The stronger of the two paths (reflected, refracted) is followed. Outside of a body the
            // other one ends here, unless it is a reflection that counts. Light that is reflected inside
            // leaves elsewhere, and is counted as if it left with the refracted light.
            float part = coverage * clarity;
            vec3 tint = leaves ? vec3(1.0f) : m.baseColor.rgb;
            vec3 through = shares.transmitted * tint;
            vec3 followed = leaves ? vec3(1.0f) : crosses ? through : shares.reflected;
            vec3 other = crosses ? mirrored : bent.direction;
            if (hitHas(FEATURE_LIGHTS) && crosses && (pane || leaves) && m.roughness >= kMinRoughness) {
                Surface s = surfaceOf(m, -along, kMinCosine);
                Surface lobe = behindPane(s, spread);
                if (leaves) {
                    vec3 straight = refracted(along, normal, eta).direction;
                    lobe = behindBody(s, straight, travelled, p.glass.y, spread);
                }
                sum += lightBehindGlass(weight * part * followed * punctualLightAtHit(p, lobe));
            }
            if (!leaves) {
                vec3 left = weight * part * (crosses ? shares.reflected : through);
                bool splits = crosses && turns >= 1.0f && p.curvature * travelled < kFlatEnough &&
                              maxComponent(branch.weight) <= 0.0f && maxComponent(left) > kMinSplit &&
                              share * maxComponent(left) >= tracing.limits.z;
                if (splits) {
                    branch = Branch(offsetRayOrigin(p.position, p.faceNormal, p.reach), mirrored, left,
                                    RayCone(cone.width, abs(cone.pixel), cone.lobe + lobeOfPath(2.0f * alpha)),
                                    turns - 1.0f);
                } else {
                    sum += left * surroundingsAtEnd(p, other, cone, direct && !crosses);
                }
            }
            weight *= part * followed + (1.0f - coverage);
            cone.lobe += lobeOfPath(spread);
            if (solid) {
                cone.pixel = crosses ? slopeBehind(cone, p.bulges ? p.curvature : -p.curvature, eta)
                                     : abs(cone.pixel) + 2.0f * p.curvature * cone.width;
            }
        }
        if (veil) weight *= 1.0f - coverage;
        if (mirror) {
            next = mirroredAt(along, facetAt(normal, along, alpha), p.faceNormal);
            crosses = false;
            weight *= reflectance;
            cone.lobe += lobeOfPath(2.0f * alpha);
            cone.pixel = abs(cone.pixel) + 2.0f * p.curvature * cone.width;
        }
        direct = direct && crosses;
        bool turned = solid || pane || mirror;
        bool passed = hole || veil;
        bool plain = crosses || (leaves && p.curvature * travelled < kFlatEnough);
        turns -= turned ? (plain ? kTurnOfGlass : 1.0f) : 0.0f;
        holes -= passed ? 1 : 0;
        bool counts = share * maxComponent(weight) >= tracing.limits.z;
        going = (turned && turns > -1e-3f && counts) || passed;
        // No bounce left.
        if (!going && turned) sum += weight * surroundingsAtEnd(p, next, cone, direct);
        start = offsetRayOrigin(p.position + worldAxes(aside), crosses ? -p.faceNormal : p.faceNormal, p.reach);
        if (going) along = next;
    } while (going || maxComponent(branch.weight) > 0.0f);
    return sum;
}
