// Smooths edges of the display colour, after an idea of Lottes (FXAA, 2009): where brightness
// changes within a pixel's neighbourhood, the pixel is blended with its surroundings along the edge
// and never across it. VARIANT: EDGES_COMPRESSED if the tone curve compresses bright colours,
// EDGES_OF_SAMPLES if pixels have several samples.
//
// Alpha holds each pixel's brightness (see tone_map.frag), so that one gather reads four of them.
#include "include/block_macros.glsl"
#include "include/edge.glsl"
#include "include/optics.glsl"
#include "include/srgb.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;  // clamped, decoded to linear

out vec4 color;

// Where the Khronos curve begins to roll off, and what is left up to white.
const float kRollOff = 0.76f, kRoom = 0.24f;
// Finite light for white: 31.
const float kKept = 127.0f / 128.0f;

// Display light before the curve compressed it.
vec3 uncompressed(vec3 display) {
    vec3 above = max(display - kRollOff, vec3(0.0f));
    return min(display, vec3(kRollOff)) + kRoom * kRoom / (kRoom - kKept * above) - kRoom;
}

vec3 compressed(vec3 light) {
    vec3 above = max(light - kRollOff, vec3(0.0f));
    return min(min(light, vec3(kRollOff)) + kRoom / kKept * above / (above + kRoom), vec3(1.0f));
}

vec3 lightOf(vec3 display) {
    return (VARIANT & EDGES_COMPRESSED) != 0 ? uncompressed(display) : display;
}

vec3 displayed(vec3 light) {
    return (VARIANT & EDGES_COMPRESSED) != 0 ? compressed(light) : min(light, vec3(1.0f));
}

void addTexel(ivec2 texel, float share, inout vec3 light) {
    light += share *
             lightOf(texelFetch(source, clamp(texel, ivec2(0), textureSize(source, 0) - 1), 0).rgb);
}

// at: in texels, whose centres are at integers.
void addLookup(vec2 at, float share, inout vec3 light) {
    vec2 low = floor(at);
    vec2 part = at - low;
    ivec2 texel = ivec2(low);
    addTexel(texel, share * (1.0f - part.x) * (1.0f - part.y), light);
    addTexel(texel + ivec2(1, 0), share * part.x * (1.0f - part.y), light);
    addTexel(texel + ivec2(0, 1), share * (1.0f - part.x) * part.y, light);
    addTexel(texel + ivec2(1, 1), share * part.x * part.y, light);
}

vec3 codesOf(vec3 display) {
    return floor(255.0f * srgbFromLinear(display) + 0.5f);
}

// How much of the pixel the other side of the edge covers is not known, only its mean. The result is what
// is seen on average if it covers nothing or twice as much, with equal chance; what is seen are sRGB
// codes. light: the mean.
vec3 blended(vec3 center, vec3 light, float share) {
    vec3 twice = displayed(max(2.0f * light - lightOf(center), vec3(0.0f)));
    vec3 codes = mix(codesOf(center), codesOf(twice), 0.5f * share);
    return linearFromSrgb(floor(codes + 0.5f) / 255.0f);
}

void main() {
    vec2 texel = 1.0f / vec2(textureSize(source, 0));
    vec2 at = gl_FragCoord.xy * texel;
    // Four pixels each: x upper left, y upper right, z lower right, w lower left of the corner.
    vec4 low = textureGather(source, at - 0.5f * texel, 3);   // this pixel is y, the upper right
    vec4 high = textureGather(source, at + 0.5f * texel, 3);  // this pixel is w, the lower left
    vec4 center = texelFetch(source, ivec2(gl_FragCoord.xy), 0);

    float least = min(center.a, min(min(low.x, low.z), min(high.x, high.z)));
    float most = max(center.a, max(max(low.x, low.z), max(high.x, high.z)));
    color = vec4(center.rgb, 1.0f);
    if (most - least <= max(kMinContrast, kMinShare * most)) return;
    // low.x is the left neighbour, low.z the lower, high.x the upper, high.z the right one; the
    // corners low.w and high.y give the gradient of an edge that passes beside the pixel.
    vec2 gradient = vec2(high.z - low.x, high.x - low.z) + 0.5f * (high.y - low.w);
    vec2 along = vec2(-gradient.y, gradient.x);
    along /= max(min(abs(along.x), abs(along.y)), 0.125f * max(max(abs(along.x), abs(along.y)), 1e-3f));
    vec2 away = 0.25f * clamp(along, -kReach, kReach);

    vec3 light = vec3(0.0f);
    addLookup(gl_FragCoord.xy - 0.5f - away, 0.5f, light);
    addLookup(gl_FragCoord.xy - 0.5f + away, 0.5f, light);
    float share = shareOfEdge(center.a - low.xz, high.zx - center.a, most - least);
    color = vec4(blended(center.rgb, light, share), 1.0f);
}
