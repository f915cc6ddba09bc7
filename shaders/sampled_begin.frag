// Begins a further sample of some pixels: there the colour is that of no surface.
#include "include/block_macros.glsl"
#include "include/sampled_pixels.glsl"

out vec4 color;

void main() {
    if (!isSampled()) discard;
    color = filtering.parameters;
}
