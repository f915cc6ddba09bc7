// Premultiplied, linear display colour to straight alpha; the target encodes sRGB and has eight bits.
// Colour is divided by the alpha that the file will hold, so that rounding it loses no light.
#include "include/bindings.glsl"

layout(binding = UNIT_SOURCE) uniform sampler2D source;

out vec4 color;

void main() {
    vec4 premultiplied = texelFetch(source, ivec2(gl_FragCoord.xy), 0);
    float alpha = floor(clamp(premultiplied.a, 0.0f, 1.0f) * 255.0f + 0.5f) / 255.0f;
    color = vec4(alpha > 0.0f ? min(premultiplied.rgb / alpha, vec3(1.0f)) : vec3(0.0f), alpha);
}
