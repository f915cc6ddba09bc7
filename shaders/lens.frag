// A part of a frame from the picture of one tile of its lens. VARIANT: 0 radiance, which is added to that
// of other tiles by weight; 1 numbers, which are never mixed.
#include "include/filter_source.glsl"

// Of each pixel: its place in the tile, its weight there, and the factor on depth.
layout(binding = UNIT_LENS) uniform sampler2D lookups;

out vec4 color;

vec4 lookupAt(ivec2 at) {
    bool within = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, textureSize(lookups, 0)));
    return within ? texelFetch(lookups, at, 0) : vec4(0.0f);
}

// Texels from one pixel to the next: the smaller of two changes, because the other one may cross an
// edge between parts of the frame.
vec2 changeAlong(ivec2 at, vec2 here, ivec2 along) {
    vec4 ahead = lookupAt(at + along), behind = lookupAt(at - along);
    vec2 after = ahead.xy - here, before = here - behind.xy;
    if (ahead.z <= 0.0f) return behind.z > 0.0f ? before : vec2(0.0f);
    return behind.z > 0.0f && dot(before, before) < dot(after, after) ? before : after;
}

// Two look-ups along it cover a pixel that is two texels wide; at one texel they are one.
vec2 halfApart(vec2 change) {
    return 0.25f * change * clamp(2.0f - 2.0f / max(length(change), 1.0f), 0.0f, 1.0f);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(filtering.parameters.xy);
    vec4 here = lookupAt(at);
    if (here.z <= 0.0f) discard;
    if (VARIANT == LENS_NUMBERS) {
        ivec2 size = textureSize(source, 0);
        color = texelFetch(source, clamp(ivec2(here.xy), ivec2(0), size - 1), 0);
        if (filtering.parameters.z > 0.0f) color.x *= here.w;
    } else {
        vec2 u = halfApart(changeAlong(at, here.xy, ivec2(1, 0)));
        vec2 v = halfApart(changeAlong(at, here.xy, ivec2(0, 1)));
        vec4 pixel = pixelBetween(source, here.xy);
        if (dot(u, u) + dot(v, v) > 0.0f) {
            pixel = 0.25f * (pixelBetween(source, here.xy + u + v) + pixelBetween(source, here.xy + u - v) +
                             pixelBetween(source, here.xy - u + v) + pixelBetween(source, here.xy - u - v));
        }
        color = vec4(radianceFinite(here.z * pixel.rgb), here.z * clamp(pixel.a, 0.0f, 1.0f));
    }
}
