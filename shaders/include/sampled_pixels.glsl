// Which pixels of a target get a further sample; see plan/graph/supersampling.h.
layout(binding = UNIT_SAMPLED_PIXELS) uniform sampler2D sampledPixels;

bool isSampled() {
    return texelFetch(sampledPixels, ivec2(gl_FragCoord.xy), 0).r == 0.0f;
}
