// The edge filter (edge_filter.frag) of a picture with alpha. Edges are those of brightness and those of
// alpha; colour is premultiplied, so that both are blended alike. VARIANT: EDGES_OF_SAMPLES.
#include "include/block_macros.glsl"
#include "include/edge.glsl"
#include "include/optics.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;  // bilinear, clamped

out vec4 color;

vec2 seenAt(ivec2 texel) {  // brightness, alpha
    vec4 t = texelFetch(source, clamp(texel, ivec2(0), textureSize(source, 0) - 1), 0);
    return vec2(sqrt(max(luminance(t.rgb), 0.0f)), t.a);
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 center = seenAt(here);
    vec2 left = seenAt(here - ivec2(1, 0)), right = seenAt(here + ivec2(1, 0));
    vec2 lower = seenAt(here - ivec2(0, 1)), upper = seenAt(here + ivec2(0, 1));
    vec2 least = min(center, min(min(left, lower), min(upper, right)));
    vec2 most = max(center, max(max(left, lower), max(upper, right)));
    vec2 corner = seenAt(here + ivec2(1, 1)) - seenAt(here - ivec2(1, 1));
    vec2 across = right - left + 0.5f * corner, above = upper - lower + 0.5f * corner;
    vec2 gradient = vec2(across.x + across.y, above.x + above.y);
    vec2 along = vec2(-gradient.y, gradient.x);
    along /= max(min(abs(along.x), abs(along.y)), 0.125f * max(max(abs(along.x), abs(along.y)), 1e-3f));
    vec2 texel = 1.0f / vec2(textureSize(source, 0));
    vec2 at = gl_FragCoord.xy * texel;
    vec2 stride = clamp(along, -kReach, kReach) * texel;
    vec4 before = textureLod(source, at - 0.25f * stride, 0.0f);
    vec4 after = textureLod(source, at + 0.25f * stride, 0.0f);
    vec2 contrast = most - least;
    bool edge = contrast.x > max(kMinContrast, kMinShare * most.x) || contrast.y > kMinContrast;
    const vec2 kBoth = vec2(1.0f);
    float share = shareOfEdge(vec2(dot(center - left, kBoth), dot(center - lower, kBoth)),
                              vec2(dot(right - center, kBoth), dot(upper - center, kBoth)),
                              dot(contrast, kBoth));
    vec4 own = texelFetch(source, here, 0);
    color = edge ? mix(own, 0.5f * (before + after), share) : own;
}
