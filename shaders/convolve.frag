// Convolution of each pixel's neighbourhood with nine weights. Negative results become 0.
#include "include/filter_source.glsl"

out vec4 color;

void main() {
    ivec2 size = textureSize(source, 0);
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0f);
    int row = 0;
    do {
        int column = 0;
        do {
            ivec2 texel = here + ivec2(column - 1, 1 - row);  // rows of the picture grow upwards
            if (filtering.parameters.x > 0.0f) texel = (texel + size) % size;
            sum += filtering.kernel[row][column] * pixelAt(source, texel);
        } while (++column < 3);
    } while (++row < 3);
    color = vec4(radianceFinite(sum.rgb), clamp(sum.a, 0.0f, 1.0f));
}
