// Light that comes along a ray through the scene: smooth mirrors and glass send it on, whatever else
// it meets is shaded as a pixel of it would be, and where nothing is, there is the environment.
// After lighting.glsl, glass.glsl and hit.glsl.

// A surface that mirrors the scene (scene/classification.h) continues rays if it is smoother than
// kTracedRoughness and reflects more than kMinMirrored of the ray's light; else it mirrors the
// environment.
const float kTracedRoughness = 0.3f;
const float kMinMirrored = 0.05f;
// Flat: the normal turns by less than this, radians, over the ray's length.
const float kFlatEnough = 1e-3f;
// Holes of masks that a path may pass.
const int kMaxHoles = 12;

// Slope of a pixel's cone from which on the environment is averaged over it.
const float kWidePixel = 0.5f;

// Slopes of the cone that a ray represents: that of its pixel chooses levels of textures, that of
// rough surfaces those of the environment, too.
struct RayCone {
    float width;  // metres, where the ray starts
    float pixel;
    float lobe;
};

vec3 environmentAtEnd(vec3 along, RayCone cone) {
    // Half a cone's slope is the alpha of a mirror that has such a lobe. A pixel's footprint is uniform, without
    // tails, and matters only where it is wide: glass and small round things, mirrored again.
    float alpha = 0.5f * cone.lobe + 0.25f * max(cone.pixel - kWidePixel, 0.0f);
    return environmentAlong(along, min(sqrt(alpha), 1.0f));
}

// The surface for a cone that hits it: a cone is given by its width, so its half vectors reach half of
// what they turn by to every side. It covers more of what it meets at an angle: along the sight its
// width over n.v, and where the surface turns away from it no more than what is left of a ball. Wider
// ones see more than this surface.
const float kMaxTurned = 0.84f;
Surface coveredByCone(Surface s, float curvature, RayCone cone) {
    float across = curvature * cone.width;
    float slant = across / max(max(s.nDotV, sqrt(0.5f * across)), 1e-6f);
    float spread = 0.5f * (cone.pixel + cone.lobe);
    const float kEdge = 0.8862269f;  // of a square as large as a disc, over its diameter
    vec3 side = cross(s.normal, s.toEye);
    side = dot(side, side) > kNoDirection ? direction(side) : frameAbout(s.normal)[0];
    return covering(s, cross(side, s.normal) * (kEdge * min(slant + spread, kMaxTurned)),
                    side * (kEdge * min(across + spread, kMaxTurned)));
}

// Away from the face that a ray leaves from, on the side of `normal`. Corners and sums of them are
// off by some 2^-22 of their greatest coordinate.
vec3 offsetRayOrigin(vec3 place, vec3 normal, float reach) {
    return place + worldAxes(normal) * (2e-6f * reach + 1e-30f);
}

// The mirrored direction of a bumpy or smoothed normal may point into the face itself: then it is
// laid along it.
vec3 mirroredAt(vec3 along, vec3 normal, vec3 faceNormal) {
    vec3 mirrored = reflect(along, normal);
    float above = dot(mirrored, faceNormal);
    return direction(mirrored + faceNormal * max(1e-3f - above, 0.0f));
}

vec3 lampsAtHit(HitPoint p, Surface s) {
    if (!hitHas(FEATURE_LIGHTS)) return vec3(0.0f);
    vec3 lamps = lampsLight(s, eyeAxes(p.place - tracing.eye.xyz), p.firstLight, p.lights);
    return p.lights > 0 ? lamps : vec3(0.0f);
}

// start: relative to the hierarchy's origin, off the surface that the ray leaves. along: unit, in
// eye space's axes.
vec3 tracedRadiance(vec3 start, vec3 along, RayCone cone) {
    vec3 sum = vec3(0.0f);
    vec3 weight = vec3(1.0f);
    int turns = int(tracing.limits.x);
    int holes = kMaxHoles;
    bool going = true;
    do {
        Hit hit = traceClosest(start, worldAxes(along), 0.0f, 1e30f);
        bool met = hit.place >= 0;
        float travelled = met ? hit.distance : 0.0f;
        cone.width += (cone.pixel + cone.lobe) * travelled;
        HitPoint p = hitPoint(hit, along, cone.width);
        MaterialPoint m = p.material;

        // As pixels are: cut out by masks, and not drawn from the back of one-sided surfaces.
        bool back = !p.front && (p.flags & (TRACE_DOUBLE_SIDED | TRACE_SOLID)) == 0;
        bool hole = met && holes > 0 && (m.baseColor.a < p.cutoff || back);
        bool there = met && !hole;
        bool unlit = hitHas(FEATURE_UNLIT) && (p.flags & TRACE_UNLIT) != 0;
        float coverage = 1.0f;
        if (hitHas(FEATURE_BLEND)) {
            bool blends = holes > 0 && (p.flags & TRACE_BLEND) != 0;
            coverage = blends ? clamp(m.baseColor.a, 0.0f, 1.0f) : 1.0f;
        }
        bool solid = false;
        bool pane = false;
        float clarity = 0.0f;  // share that lets light through
        float dull = 1.0f;     // of the dielectric part
        if (hitHas(FEATURE_GLASS)) {
            bool glass = there && p.glass.x > 0.0f;
            solid = glass && (p.flags & TRACE_SOLID) != 0;
            pane = glass && (p.flags & TRACE_PANE) != 0;
            dull = solid || pane ? 1.0f - clamp(p.glass.x, 0.0f, 1.0f) : 1.0f;
            clarity = solid || pane ? clearShare(p.glass.x, m.metallic) : 0.0f;
            if (solid && !p.front) clarity = 1.0f;  // the way out of what was entered
        }
        bool veil = there && coverage < 1.0f && !solid && !pane;
        Surface s = surfaceOf(m, -along);
        bool level = p.curvature * hit.distance < kFlatEnough;
        bool mirror = there && !solid && !pane && !veil && !unlit &&
                      (p.flags & (level ? TRACE_MIRROR_FLAT : TRACE_MIRROR_CURVED)) != 0 &&
                      m.roughness <= kTracedRoughness &&
                      maxComponent(weight * s.reflectance) > kMinMirrored;

        // What the surface itself sends along the ray: all but what the path goes on for.
        vec3 around = environmentAlong(reflect(along, s.normal), s.roughness);
        Surface unclear = s;
        if (hitHas(FEATURE_GLASS)) {
            m.metallic = solid || pane ? metallicBesideGlass(p.glass.x, m.metallic) : m.metallic;
            unclear = surfaceOf(m, -along);
        }
        vec3 environment = environmentLight(unclear, mirror ? vec3(0.0f) : around) *
                           (solid || pane ? 1.0f : m.occlusion);
        Surface opaque = s;
        opaque.diffuse *= dull;
        opaque = coveredByCone(opaque, p.curvature, cone);
        vec3 own = (1.0f - clarity) * environment + lampsAtHit(p, opaque);
        if (solid && !p.front) own = vec3(0.0f);
        if (unlit) own = m.baseColor.rgb;
        if (there) sum += weight * (coverage * own + m.emitted);

        vec3 normal = dot(m.normal, along) < 0.0f ? m.normal : p.faceNormal;
        float alpha = m.roughness * m.roughness;
        vec3 next = along;
        vec3 aside = vec3(0.0f);
        bool crosses = true;  // goes on behind the face
        if (hitHas(FEATURE_GLASS)) {
            float c = -dot(along, normal);
            bool leaves = solid && !p.front;  // a pane has no inside
            float eta = leaves ? 1.0f / p.glass.y : p.glass.y;
            float fresnel = fresnelOfBody(c, eta, m.specular);
            vec3 mirrored = mirroredAt(along, normal, p.faceNormal);
            Refraction bent = refracted(along, normal, eta);
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
            if (pane) aside = asideInPane(along, normal, way, p.glass.z);
            if (solid || pane) {
                // The stronger of the two ways is followed. Of what is outside the other one sees the
                // environment; what turns back inside leaves elsewhere, and is counted as if it left
                // with the rest.
                float part = coverage * clarity;
                vec3 tint = leaves ? vec3(1.0f) : m.baseColor.rgb;
                vec3 through = shares.transmitted * tint;
                vec3 followed = leaves ? vec3(1.0f) : crosses ? through : shares.reflected;
                vec3 left = leaves ? vec3(0.0f) : crosses ? shares.reflected : through;
                vec3 other = crosses ? mirrored : bent.direction;
                sum += weight * part * left * environmentAtEnd(other, cone);
                weight *= part * followed + (1.0f - coverage);
                cone.lobe += glassSpread(alpha, c, p.glass.y);
                float turn = p.curvature * cone.width;  // of the normal over the cone
                cone.pixel += solid ? (crosses ? abs(eta - 1.0f) : 2.0f) * turn : 0.0f;
            }
        }
        if (veil) weight *= 1.0f - coverage;
        if (mirror) {
            next = mirroredAt(along, normal, p.faceNormal);
            crosses = false;
            weight *= m.occlusion * s.reflectance;
            cone.lobe += 2.0f * alpha;
            cone.pixel += 2.0f * p.curvature * cone.width;
        }
        bool turned = solid || pane || mirror;
        bool passed = hole || veil;
        turns -= turned ? 1 : 0;
        holes -= passed ? 1 : 0;
        going = (turned && turns >= 0) || passed;
        // Nothing more to meet, or no turn left: the rest is the environment's.
        if (!going && (turned || !met)) sum += weight * environmentAtEnd(next, cone);
        start = offsetRayOrigin(p.place + worldAxes(aside), crosses ? -p.faceNormal : p.faceNormal, p.reach);
        if (going) along = next;
    } while (going);
    return sum;
}

// ---- from a pixel ------------------------------------------------------------------------------

// The face's normal at this pixel, towards the eye.
vec3 faceNormalAt(vec3 position, vec3 toEye, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    face = dot(face, face) > 0.0f ? normalize(face) : normal;
    return dot(face, toEye) < 0.0f ? -face : face;
}

// Where the line of sight that surface.frag takes meets the triangle's plane. What a driver says of
// the position there may have the length of another point: at the pixel's centre, which can lie far
// beside a triangle that is seen edge-on.
vec3 coveredPosition(vec3 position, vec3 face) {
    vec3 covered = interpolateAtCentroid(positionEye);
    float along = dot(face, covered);
    float scale = dot(face, position) / (abs(along) > 1e-30f ? along : 1.0f);
    return scale > 0.0f && scale < 1e6f ? covered * scale : position;
}

// Interpolated positions are off by more than corners are.
vec3 startBeside(vec3 position, vec3 normal) {
    vec3 covered = coveredPosition(position, normal);
    vec3 place = tracing.eye.xyz + worldAxes(covered);
    float reach = max(abs(place.x), max(abs(place.y), abs(place.z)));
    return offsetRayOrigin(place, normal, reach + 5.0f * length(covered));
}

float changeInPixel(vec3 v) {
    return max(length(dFdx(v)), length(dFdy(v)));
}

RayCone coneAt(vec3 position, vec3 towards, float lobe) {
    return RayCone(changeInPixel(position), min(changeInPixel(towards), 1.0f), lobe);
}

vec3 tracedReflection(Surface s, vec3 position) {
    vec3 face = faceNormalAt(position, s.toEye, s.normal);
    vec3 towards = mirroredAt(-s.toEye, s.normal, face);
    float lobe = 2.0f * s.roughness * s.roughness;
    return tracedRadiance(startBeside(position, face), towards, coneAt(position, towards, lobe));
}

// Clear glass: the mirrored ray first, then the one that goes through, and starts so far `aside`.
struct GlassRays {
    vec3 mirrored;
    vec3 through;
};
GlassRays tracedThrough(Surface s, vec3 position, vec3 aside, vec3 inside, float lobe) {
    vec3 face = faceNormalAt(position, s.toEye, s.normal);
    vec3 towards = mirroredAt(-s.toEye, s.normal, face);
    GlassRays rays = GlassRays(vec3(0.0f), vec3(0.0f));
    RayCone mirroredCone = coneAt(position, towards, 2.0f * s.roughness * s.roughness);
    RayCone insideCone = coneAt(position, inside, lobe);
    int ray = 0;
    do {  // one loop, so that the path stands in the program once
        bool first = ray == 0;
        vec3 start = startBeside(position, first ? face : -face);
        vec3 radiance = tracedRadiance(first ? start : start + worldAxes(aside),
                                       first ? towards : inside,
                                       RayCone(mirroredCone.width,
                                               first ? mirroredCone.pixel : insideCone.pixel,
                                               first ? mirroredCone.lobe : insideCone.lobe));
        rays.mirrored = first ? radiance : rays.mirrored;
        rays.through = radiance;
        ++ray;
    } while (ray < 2);
    return rays;
}
