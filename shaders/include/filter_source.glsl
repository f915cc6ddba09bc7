// The picture that a filter reads: linear radiance, read texel by texel, so that every driver sees
// the same numbers. Beyond a border lies its nearest texel.
#include "include/block_macros.glsl"
#include "include/optics.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

// Alpha counts in transparent pictures only, whose light is premultiplied; others hold distances there.
vec4 pixelAt(sampler2D picture, ivec2 texel) {
    return texelFetch(picture, clamp(texel, ivec2(0), textureSize(picture, 0) - 1), 0);
}

vec3 texelAt(sampler2D picture, ivec2 texel) {
    return pixelAt(picture, texel).rgb;
}

// Between the four texels about it; `at` counts from the lower left corner, texel centres lie at
// halves. Not the sampler's own blending, whose weights some hardware rounds to 1/256.
vec4 pixelBetween(sampler2D picture, vec2 at) {
    vec2 from = at - 0.5f;
    ivec2 low = ivec2(floor(from));
    vec2 share = from - vec2(low);
    vec4 lower = mix(pixelAt(picture, low), pixelAt(picture, low + ivec2(1, 0)), share.x);
    vec4 upper = mix(pixelAt(picture, low + ivec2(0, 1)), pixelAt(picture, low + ivec2(1, 1)), share.x);
    return mix(lower, upper, share.y);
}

vec3 between(sampler2D picture, vec2 at) {
    return pixelBetween(picture, at).rgb;
}
