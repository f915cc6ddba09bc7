// Light that comes along a ray through the scene: smooth metal and glass send it on, whatever else
// it meets is shaded as a pixel of it would be, and where nothing is, there is the environment.
// After lighting.glsl, glass.glsl and hit.glsl.

// A metal smoother than this sends rays on; a rougher one is shaded.
const float kTracedMetallic = 0.5f;
const float kTracedRoughness = 0.3f;
// Holes of masks that a path may pass.
const int kMostHoles = 12;

// Slopes of the cone that a ray stands for: that of its pixel chooses levels of textures, that of
// rough surfaces those of the environment, too.
struct RayCone {
    float width;  // metres, where the ray starts
    float pixel;
    float lobe;
};

vec3 environmentAtEnd(vec3 along, RayCone cone) {
    return environmentAlong(along, min(sqrt(0.5f * cone.lobe), 1.0f));
}

// Away from the face that a ray leaves from, on the side of `normal`. Corners and sums of them are
// off by some 2^-22 of their greatest coordinate.
vec3 beside(vec3 place, vec3 normal, float reach) {
    return place + worldAxes(normal) * (2e-6f * reach + 1e-30f);
}

// The mirrored direction of a bumpy or smoothed normal may point into the face itself: then it is
// laid along it.
vec3 mirroredAt(vec3 along, vec3 normal, vec3 faceNormal) {
    vec3 mirrored = reflect(along, normal);
    float above = dot(mirrored, faceNormal);
    return direction(mirrored + faceNormal * max(1e-3f - above, 0.0f));
}

// What leaves a point of a surface against the ray, by lamps and environment.
vec3 radianceAtHit(HitPoint p, vec3 along) {
    MaterialPoint m = p.material;
    Surface s = surfaceOf(m, -along);
    vec3 lit = m.occlusion * environmentLight(s, environmentAlong(reflect(along, s.normal), s.roughness));
    if (hitHas(FEATURE_LIGHTS)) {
        vec3 position = eyeAxes(p.place - tracing.eye.xyz);
        vec3 lamps = lampsLight(s, position, p.firstLight, p.lights);
        lit += p.lights > 0 ? lamps : vec3(0.0f);
    }
    if (hitHas(FEATURE_UNLIT)) lit = (p.flags & TRACE_UNLIT) != 0 ? m.baseColor.rgb : lit;
    return lit + m.emitted;
}

// start: relative to the hierarchy's origin, off the surface that the ray leaves. along: unit, in
// eye space's axes.
vec3 tracedRadiance(vec3 start, vec3 along, RayCone cone) {
    vec3 sum = vec3(0.0f);
    vec3 weight = vec3(1.0f);
    int turns = int(tracing.limits.x);
    int holes = kMostHoles;
    bool going = true;
    bool ends = false;
    HitPoint last;
    do {
        Hit hit = traceClosest(start, worldAxes(along), 0.0f, 1e30f);
        bool met = hit.place >= 0;
        float travelled = met ? hit.distance : 0.0f;
        cone.width += (cone.pixel + cone.lobe) * travelled;
        HitPoint p = hitPoint(hit, along, cone.width);
        MaterialPoint m = p.material;

        bool hole = met && holes > 0 && m.baseColor.a < p.cutoff;
        bool solid = false;
        bool pane = false;
        if (hitHas(FEATURE_GLASS)) {
            bool clear = met && !hole && p.glass.x >= 0.5f;
            solid = clear && (p.flags & TRACE_SOLID) != 0;
            pane = clear && (p.flags & TRACE_PANE) != 0;
        }
        bool mirror = met && !hole && !solid && !pane && (p.flags & TRACE_UNLIT) == 0 &&
                      m.metallic >= kTracedMetallic && m.roughness <= kTracedRoughness;
        vec3 normal = dot(m.normal, along) < 0.0f ? m.normal : p.faceNormal;
        float alpha = m.roughness * m.roughness;
        vec3 next = along;
        bool crosses = true;  // goes on behind the face
        if (hitHas(FEATURE_GLASS)) {
            float c = -dot(along, normal);
            float eta = p.front ? p.glass.y : 1.0f / p.glass.y;
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
                next = bent.total ? mirrored : bent.direction;
                crosses = !bent.total;
            }
            if (solid && bent.total) shares = GlassShares(vec3(0.0f), vec3(1.0f));
            if (solid || pane) {
                // What turns back here is not followed: it sees the environment.
                sum += weight * shares.reflected * environmentAtEnd(mirrored, cone);
                weight *= shares.transmitted * (p.front || pane ? m.baseColor.rgb : vec3(1.0f));
                cone.lobe += solid ? glassSpread(alpha, c, p.glass.y) : 0.0f;
            }
        }
        Surface s = surfaceOf(m, -along);
        if (mirror) {
            next = mirroredAt(along, normal, p.faceNormal);
            crosses = false;
            sum += weight * m.emitted;
            weight *= s.reflectance;
            cone.lobe += 2.0f * alpha;
            cone.pixel += 2.0f * p.curvature * cone.width;
        }
        bool turned = solid || pane || mirror;
        bool opaque = met && !hole && !turned;
        last = p;
        ends = opaque;
        turns -= turned ? 1 : 0;
        holes -= hole ? 1 : 0;
        going = (turned && turns >= 0) || hole;
        // Nothing more to meet, or no turn left: the rest is the environment's.
        if (!going && !opaque) sum += weight * environmentAtEnd(next, cone);
        start = beside(p.place, crosses ? -p.faceNormal : p.faceNormal, p.reach);
        if (going) along = next;
    } while (going);
    if (ends) sum += weight * radianceAtHit(last, along);
    return sum;
}

// ---- from a pixel ------------------------------------------------------------------------------

// The face's normal at this pixel, towards the eye.
vec3 faceNormalAt(vec3 position, vec3 toEye, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    face = dot(face, face) > 0.0f ? normalize(face) : normal;
    return dot(face, toEye) < 0.0f ? -face : face;
}

// Interpolated positions are off by more than corners are.
vec3 startBeside(vec3 position, vec3 normal) {
    vec3 place = tracing.eye.xyz + worldAxes(position);
    float reach = max(abs(place.x), max(abs(place.y), abs(place.z)));
    return beside(place, normal, reach + 5.0f * length(position));
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

// Clear glass: the mirrored ray first, then the one that goes through.
struct GlassRays {
    vec3 mirrored;
    vec3 through;
};
GlassRays tracedThrough(Surface s, vec3 position, vec3 inside, float lobe) {
    vec3 face = faceNormalAt(position, s.toEye, s.normal);
    vec3 towards = mirroredAt(-s.toEye, s.normal, face);
    GlassRays rays = GlassRays(vec3(0.0f), vec3(0.0f));
    RayCone mirroredCone = coneAt(position, towards, 2.0f * s.roughness * s.roughness);
    RayCone insideCone = coneAt(position, inside, lobe);
    int ray = 0;
    do {  // one loop, so that the path stands in the program once
        bool first = ray == 0;
        vec3 radiance = tracedRadiance(startBeside(position, first ? face : -face),
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
