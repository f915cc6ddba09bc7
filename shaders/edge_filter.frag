// Smooths edges of the display colour, after an idea of Lottes (FXAA, 2009): where brightness
// changes within a pixel's neighbourhood, the pixel is blended with its surroundings along the edge
// and never across it.
//
// Alpha holds each pixel's brightness (see tone_map.frag), so that one gather reads four of them.
#include "include/bindings.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;  // bilinear, clamped, decoded to linear

out vec4 color;

// Differences of brightness below this are no edge: absolute, and as a share of the brightest.
const float kMinContrast = 0.03f;
const float kMinShare = 0.12f;
// Pixels along the edge, each way. Long for edges near the axes, whose steps are long.
const float kReach = 2.0f;

void main() {
    vec2 texel = 1.0f / vec2(textureSize(source, 0));
    vec2 at = gl_FragCoord.xy * texel;
    // Four pixels each: x upper left, y upper right, z lower right, w lower left of the corner.
    vec4 low = textureGather(source, at - 0.5f * texel, 3);   // this pixel is y, the upper right
    vec4 high = textureGather(source, at + 0.5f * texel, 3);  // this pixel is w, the lower left
    vec4 center = texelFetch(source, ivec2(gl_FragCoord.xy), 0);

    float least = min(center.a, min(min(low.x, low.z), min(high.x, high.z)));
    float most = max(center.a, max(max(low.x, low.z), max(high.x, high.z)));
    // low.x is the left neighbour, low.z the lower, high.x the upper, high.z the right one; the
    // corners low.w and high.y give the gradient of an edge that passes beside the pixel.
    vec2 gradient = vec2(high.z - low.x, high.x - low.z) + 0.5f * (high.y - low.w);
    vec2 along = vec2(-gradient.y, gradient.x);
    along /= max(min(abs(along.x), abs(along.y)), 0.125f * max(max(abs(along.x), abs(along.y)), 1e-3f));
    vec2 stride = clamp(along, -kReach, kReach) * texel;

    vec3 before = textureLod(source, at - 0.25f * stride, 0.0f).rgb;
    vec3 after = textureLod(source, at + 0.25f * stride, 0.0f).rgb;
    bool edge = most - least > max(kMinContrast, kMinShare * most);
    color = vec4(edge ? 0.5f * (before + after) : center.rgb, 1.0f);
}
