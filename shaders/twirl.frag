// Rotates the image about its centre, by an angle that depends on the distance from it. Needs no polar
// angle of a pixel, which is undefined in the centre (erratum M2).
#include "include/filter_source.glsl"

out vec4 color;

void main() {
    vec2 center = 0.5f * vec2(textureSize(source, 0));
    vec2 arm = gl_FragCoord.xy - center;
    float radius = length(arm);
    // What is seen here lies counter-clockwise from here; rows grow upwards.
    float angle = filtering.parameters.x * radius;
    vec2 turned = mat2(cos(angle), sin(angle), -sin(angle), cos(angle)) * arm;
    vec4 pixel = pixelAt(source, ivec2(gl_FragCoord.xy));
    if (radius <= filtering.parameters.y) pixel = pixelBetween(source, center + turned);
    color = vec4(radianceFinite(pixel.rgb), pixel.a);
}
