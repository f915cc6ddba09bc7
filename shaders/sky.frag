// The environment map itself, at its own resolution.
#include "include/block_macros.glsl"
#include "include/optics.glsl"
#include "include/distance_share.glsl"

layout(binding = UNIT_SOURCE) uniform samplerCube source;

in vec3 towards;
out vec4 color;

void main() {
    vec3 radiance = textureLod(source, towards, 0.0f).rgb;
    color = vec4(radianceFinite(radiance * view.environment.y), kFarShare);
}
