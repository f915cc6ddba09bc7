// Rays that start from a pixel of a mirror or of glass. They are traced in the same program
// (ray_path.glsl), or written as records that the processor traces (RECORDS_RAYS, see ray_record.glsl);
// then their radiance is added later. After lighting.glsl.
#include "include/ray.glsl"

struct PixelRay {
    vec3 start;  // world axes, from the hierarchy's origin; off the surface
    vec3 along;  // unit, eye space's axes
    RayCone cone;
    RoundLobe whole;  // the cone as one look-up or one path
};

// The face's normal at this pixel, towards the eye.
vec3 faceNormalAt(vec3 position, vec3 toEye, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    face = dot(face, face) > 0.0f ? normalize(face) : normal;
    return dot(face, toEye) < 0.0f ? -face : face;
}

// Interpolated positions have larger errors than corners.
vec3 startBeside(vec3 position, vec3 normal) {
    vec3 origin = tracing.eye.xyz + worldAxes(position);
    float reach = max(abs(origin.x), max(abs(origin.y), abs(origin.z)));
    return offsetRayOrigin(origin, normal, reach + 5.0f * length(position));
}

float changeInPixel(vec3 v) {
    return max(length(dFdx(v)), length(dFdy(v)));
}

RayCone coneAt(vec3 position, vec3 towards, float lobe) {
    return RayCone(changeInPixel(position), min(changeInPixel(towards), 1.0f), lobe);
}

PixelRay mirroredRay(Surface s, vec3 position) {
    vec3 face = faceNormalAt(position, s.toEye, s.normal);
    vec3 towards = mirroredAt(-s.toEye, s.normal, face);
    float lobe = 2.0f * s.roughness * s.roughness;
    return PixelRay(startBeside(position, face), towards, coneAt(position, towards, lobe),
                    mirroredLobe(towards, s.toEye, lobe));
}

// Above 0 where rays of neighbouring pixels part.
float partingOf(vec3 position, vec3 towards) {
    return dot(dFdx(position), dFdx(towards)) + dot(dFdy(position), dFdy(towards));
}

// Into or out of clear glass; starts so far `aside`.
PixelRay transmittedRay(Surface s, vec3 position, vec3 aside, vec3 inside, float lobe) {
    vec3 face = faceNormalAt(position, s.toEye, s.normal);
    RayCone cone = coneAt(position, inside, lobe);
    if (partingOf(position, inside) < 0.0f) cone.pixel = -cone.pixel;
    return PixelRay(startBeside(position, -face) + worldAxes(aside), inside, cone,
                    RoundLobe(inside, 0.5f * lobe));
}

struct GlassRays {
    vec3 mirrored;
    vec3 through;
};

#if RECORDS_RAYS
#include "include/ray_record.glsl"
#else
#include "include/trace.glsl"

// Paths through bodies that disperse light are of one primary each: 0 red, 1 green, 2 blue. Other
// bodies have one index for all, that of green.
int primaryOfPath = 1;
float iorOfPath(float ior, float dispersion) {
    vec3 iors = dispersedIors(ior, dispersion);
    return primaryOfPath == 0 ? iors.x : primaryOfPath == 1 ? ior : iors.z;
}

#include "include/hit.glsl"
#include "include/ray_path.glsl"

vec3 tracedReflection(Surface s, vec3 position) {
    PixelRay ray = mirroredRay(s, position);
    ray.cone.lobe = 2.0f * ray.whole.alpha;
    return tracedRadiance(ray.start, ray.whole.along, ray.cone, 1.0f, false);
}

GlassRays tracedThrough(Surface s, vec3 position, vec3 aside, vec3 inside, float lobe) {
    PixelRay mirrored = mirroredRay(s, position);
    PixelRay through = transmittedRay(s, position, aside, inside, lobe);
    GlassRays rays = GlassRays(vec3(0.0f), vec3(0.0f));
    int number = 0;
    int count = hitLayered(LAYER_DISPERSION) ? 4 : 2;
    do {  // one loop, so that the program contains the code of the path once
        bool first = number == 0;
        if (number >= 2) {
            primaryOfPath = 2 * (number - 2);
            if (layered(LAYER_DISPERSION) && has(FEATURE_SOLID)) {
                float ior = iorOfPath(material.glass.y, layerBlock.clearcoat.w);
                float eta = gl_FrontFacing ? ior : 1.0f / ior;
                through.along = refracted(-s.toEye, s.normal, eta).direction;
            }
        }
        vec3 radiance = tracedRadiance(first ? mirrored.start : through.start,
                                       first ? mirrored.whole.along : through.along,
                                       RayCone(mirrored.cone.width,
                                               first ? mirrored.cone.pixel : through.cone.pixel,
                                               first ? 2.0f * mirrored.whole.alpha : through.cone.lobe),
                                       1.0f, !first);
        rays.mirrored = first ? radiance : rays.mirrored;
        rays.through = number == 2   ? vec3(radiance.r, rays.through.gb)
                       : number == 3 ? vec3(rays.through.rg, radiance.b)
                                     : radiance;
        ++number;
    } while (number < count);
    primaryOfPath = 1;
    return rays;
}

// Shares of the rays in the pixel: only records hold them.
void weighRays(vec3 mirrored, vec3 through) {
}
vec3 finishRays(float coverage) {
    return vec3(0.0f);
}
#endif
