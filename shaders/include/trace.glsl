// Rays through the scene's triangles: traversal of the hierarchy of renderer/scene/bvh.h.
// Positions are relative to its origin, in the world's axes. After block_macros.glsl.

#include "include/surface_light_sampler.glsl"
layout(binding = UNIT_TRACE_NODES) uniform samplerBuffer traceNodes;
layout(binding = UNIT_TRACE_TRIANGLES) uniform samplerBuffer traceTriangles;
layout(binding = UNIT_TRACE_VERTICES) uniform samplerBuffer traceVertices;  // two floats each
layout(binding = UNIT_TRACE_INDICES) uniform usamplerBuffer traceIndices;
layout(binding = UNIT_TRACE_INSTANCES) uniform samplerBuffer traceInstances;
layout(binding = UNIT_TRACE_MATERIALS) uniform samplerBuffer traceMaterials;  // then textures
layout(binding = UNIT_TRACE_TEXELS) uniform samplerBuffer traceTexels;

struct Hit {
    float distance;
    int triangle;    // of the triangle in traceTriangles; -1: nothing was met
    vec2 weights;  // of the triangle's second and third corner
};

// Above 1e-18 in size, with the sign.
float rayDivisor(float x) {
    return abs(x) > 1e-18f ? x : (x < 0.0f ? -1e-18f : 1e-18f);
}

// The nearest hit between tMin and tMax. direction: unit. A zero or non-finite direction, and an empty
// interval, hit nothing. Every step proceeds to a later node, so the traversal ends for any input.
Hit traceClosest(vec3 origin, vec3 direction, float tMin, float tMax) {
    Hit hit = Hit(tMax, -1, vec2(0.0f));
    float squared = dot(direction, direction);
    bool valid = squared > 0.9f && squared < 1.1f && tMin < tMax && dot(origin, origin) < 1e36f;
    int end = int(tracing.eye.w);
    int node = valid ? 0 : max(end - 1, 0);
    float from = valid ? tMin : 0.0f;
    hit.distance = valid ? tMax : -1.0f;  // then no box is met

    vec3 perUnit = 1.0f / vec3(rayDivisor(direction.x), rayDivisor(direction.y),
                               rayDivisor(direction.z));
    // Two axes across the ray (Duff et al. 2017). In their plane the ray is the origin.
    float sign = direction.z >= 0.0f ? 1.0f : -1.0f;
    float k = -1.0f / (sign + direction.z);
    float xy = direction.x * direction.y * k;
    vec3 across = vec3(1.0f + sign * direction.x * direction.x * k, sign * xy, -sign * direction.x);
    vec3 upward = vec3(xy, sign + direction.y * direction.y * k, -direction.y);

    do {
        vec4 low = texelFetch(traceNodes, TRACE_NODE_ROWS * node);
        vec4 high = texelFetch(traceNodes, TRACE_NODE_ROWS * node + 1);
        vec3 t0 = (low.xyz - origin) * perUnit;
        vec3 t1 = (high.xyz - origin) * perUnit;
        vec3 nearer = min(t0, t1);
        vec3 farther = max(t0, t1);
        bool met = max(max(nearer.x, nearer.y), max(nearer.z, from)) <=
                   min(min(farther.x, farther.y), min(farther.z, hit.distance));
        bool inner = high.w < 0.0f;
        node = met && inner ? node + 1 : int(low.w);
        if (met && !inner) {
            int leaf = int(high.w);
            int triangle = leaf >> 3;
            int last = triangle + (leaf & 7);
            do {
                vec4 a4 = texelFetch(traceTriangles, TRACE_TRIANGLE_ROWS * triangle);
                vec4 b4 = texelFetch(traceTriangles, TRACE_TRIANGLE_ROWS * triangle + 1);
                vec4 c4 = texelFetch(traceTriangles, TRACE_TRIANGLE_ROWS * triangle + 2);
                vec3 a = a4.xyz - origin;
                vec3 b = b4.xyz - origin;
                vec3 c = c4.xyz - origin;
                // Depends on corners only, so triangles that share an edge agree about it.
                precise float ax = dot(a, across);
                precise float ay = dot(a, upward);
                precise float bx = dot(b, across);
                precise float by = dot(b, upward);
                precise float cx = dot(c, across);
                precise float cy = dot(c, upward);
                // Twice the areas that the ray cuts off (Woop et al. 2013); of one sign inside.
                precise float u = cx * by - cy * bx;
                precise float v = ax * cy - ay * cx;
                precise float w = bx * ay - by * ax;
                float sum = u + v + w;
                float least = min(u, min(v, w));
                float most = max(u, max(v, w));
                // Above 0 where the ray sees a, b, c turn counter-clockwise.
                bool through = (least >= 0.0f || most <= 0.0f) && sum != 0.0f && sum * c4.w >= 0.0f;
                float t = (u * dot(a, direction) + v * dot(b, direction) + w * dot(c, direction)) /
                          (through ? sum : 1.0f);
                if (through && t > from && t < hit.distance) {
                    hit = Hit(t, triangle, vec2(v, w) / sum);
                }
                ++triangle;
            } while (triangle < last);
        }
    } while (node < end);
    return hit;
}

// The processor compares the surfaces that the paths of neighbouring pixels meet (renderer/rays).
void noteHit(int instance) {
}
// There several paths may share a rough lobe, each with a facet, a direction and a width of its own.
vec3 facetAt(vec3 normal, vec3 along, float alpha) {
    return normal;
}
vec3 beyondPane(vec3 along, float lobe) {
    return along;
}
float lobeOfPath(float lobe) {
    return lobe;
}
vec3 lightBehindGlass(vec3 light) {
    return light;
}
