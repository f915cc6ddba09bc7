// Smooths edges of the display colour. Where luma changes across a pixel, it is blended a little
// way along the edge: the edge's direction is that of the gradient turned by 90 degrees, taken from
// the four diagonal neighbours, and the steps of an almost axis-aligned edge are long, so the
// samples reach farther the more axis-aligned it is.
#include "include/bindings.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;  // bilinear, clamped, decoded to linear

out vec4 color;

// Differences of luma below this are no edge: absolute, and as a share of the brightest neighbour.
const float kLeastContrast = 0.03f;
const float kLeastShare = 0.12f;
// Pixels along the edge, at most.
const float kReach = 4.0f;

// As bright as it looks: the square root is near the display's own curve.
float luma(vec3 c) {
    return sqrt(dot(c, vec3(0.2126f, 0.7152f, 0.0722f)));
}

void main() {
    ivec2 size = textureSize(source, 0);
    ivec2 here = ivec2(gl_FragCoord.xy);
    ivec2 low = max(here - 1, ivec2(0)), high = min(here + 1, size - 1);
    vec3 center = texelFetch(source, here, 0).rgb;
    float a = luma(texelFetch(source, low, 0).rgb);
    float b = luma(texelFetch(source, ivec2(high.x, low.y), 0).rgb);
    float c = luma(texelFetch(source, ivec2(low.x, high.y), 0).rgb);
    float d = luma(texelFetch(source, high, 0).rgb);
    float m = luma(center);

    float least = min(m, min(min(a, b), min(c, d)));
    float most = max(m, max(max(a, b), max(c, d)));
    vec2 along = vec2((a + b) - (c + d), (b + d) - (a + c));  // the gradient, turned
    along.y = -along.y;
    float shorter = max(min(abs(along.x), abs(along.y)), 0.01f);
    vec2 stride = clamp(along / shorter, -kReach, kReach) / vec2(size);

    vec2 at = gl_FragCoord.xy / vec2(size);
    vec3 close = 0.5f * (textureLod(source, at - stride / 6.0f, 0.0f).rgb +
                         textureLod(source, at + stride / 6.0f, 0.0f).rgb);
    vec3 wide = 0.5f * close + 0.25f * (textureLod(source, at - stride / 2.0f, 0.0f).rgb +
                                        textureLod(source, at + stride / 2.0f, 0.0f).rgb);
    // Samples that left the neighbourhood's range have crossed into something else.
    float wideLuma = luma(wide);
    vec3 smoothed = (wideLuma < least || wideLuma > most) ? close : wide;
    bool edge = most - least > max(kLeastContrast, kLeastShare * most);
    color = vec4(edge ? smoothed : center, 1.0f);
}
