// Where a reflection is looked up and how blurred: levels of pictures by the width of a lobe, and
// the hit of a ray with a probe's surroundings. Needs nothing before it. Compiled as GLSL 4.30 and
// as C++ (see optics.glsl).
#ifndef CLERESTORY_REFLECTION_LOOKUP_GLSL
#define CLERESTORY_REFLECTION_LOOKUP_GLSL

// ---- blur --------------------------------------------------------------------------------------

// Level of a picture whose pixel is as wide as a lobe (erratum R4; for a cube map, with edge / 2
// pixels per slope, the same as environmentLod()). spread: slope of the cone, 2 alpha for a mirror
// and glassSpread() for glass. Exactly 0 for spread 0; finite for every input.
float lobeLod(float spread, float pixelsPerSlope) {
    float width = 2.44948974f * spread * pixelsPerSlope;
    return width > 1.0f ? log2(min(width, 1e18f)) : 0.0f;
}

// Share of the lobe that the eye sees: something that touches the surface is sharp. Metres from
// the eye to the surface and from there to what is seen in it; either may be infinite.
float lobeReach(float toSurface, float beyond) {
    float near = toSurface > 0.0f ? min(toSurface, 1e18f) : 0.0f;
    float far = beyond > 0.0f ? min(beyond, 1e18f) : 0.0f;
    return far / max(near + far, 1e-18f);
}

// Level of a mirrored view. focalPixels: pixels per unit slope at the middle of the picture,
// height / (2 tan(yfov / 2)). Orthographic: lobeLod(2 alpha, pixels per metre * beyond).
float mirrorLod(float roughness, float focalPixels, float toSurface, float beyond) {
    float spread = 2.0f * roughness * roughness;
    return lobeLod(spread, focalPixels * lobeReach(toSurface, beyond));
}

// ---- parallax ----------------------------------------------------------------------------------
// Positions are relative to the probe's centre, where its map was drawn from. The result is the
// unit direction to look up; outside the proxy it is the ray's own (erratum C2).

// x, moved away from 0.
float awayFromZero(float x) {
    float least = 1e-7f;
    return abs(x) < least ? (x < 0.0f ? -least : least) : x;
}

// Towards a hit; hits nearer than a micrometre to the centre say nothing.
vec3 towardsHit(vec3 hit, vec3 direction) {
    float squared = dot(hit, hit);
    return squared > 1e-12f ? hit * inversesqrt(squared) : direction;
}

vec3 boxParallax(vec3 position, vec3 direction, vec3 boxMin, vec3 boxMax) {
    // A wall that carries the mirror itself is inside, whatever rounding says.
    vec3 slack = (boxMax - boxMin) * 1e-3f;
    vec3 p = clamp(position, boxMin, boxMax);
    vec3 off = abs(position - p);
    if (!(off.x <= slack.x && off.y <= slack.y && off.z <= slack.z)) {
        return direction;
    }
    vec3 r = vec3(awayFromZero(direction.x), awayFromZero(direction.y), awayFromZero(direction.z));
    vec3 t = max((boxMax - p) / r, (boxMin - p) / r);
    return towardsHit(p + direction * min(t.x, min(t.y, t.z)), direction);
}

vec3 sphereParallax(vec3 position, vec3 direction, vec3 center, float radius) {
    vec3 p = position - center;
    float inside = radius * radius - dot(p, p);
    if (!(inside >= 0.0f)) {
        return direction;
    }
    float b = dot(p, direction);
    float root = sqrt(b * b + inside);
    // -b + root, without cancellation where b is positive.
    float t = b > 0.0f ? inside / max(b + root, 1e-18f) : root - b;
    return towardsHit(position + direction * t, direction);
}

#endif
