// What the edge filters of opaque and of transparent pictures have in common.

// Differences of brightness below these are no edge: absolute, and as a share of the brightest.
const float kMinContrast = 0.03f;
const float kMinShare = 0.12f;
// Pixels along the edge, each way. Long for edges near the axes, whose steps are long.
const float kReach = 1.25f;

// A pixel between those on both sides of an edge, and like neither, has been smoothed before: by several
// samples, by its texture or by its shading. A line shows an edge on both sides, and may need it.
// Steps of brightness from the left and the lower pixel to this one, and on to the right and the upper
// one. contrast: between the brightest and the darkest of the five; small ones are not exact.
// 1: not smoothed; 0: in the middle.
float unsmoothed(vec2 before, vec2 after, float contrast) {
    vec2 nearer = min(abs(before), abs(after)) / max(contrast, 4.0f * kMinContrast);
    vec2 part = mix(vec2(0.0f), nearer, greaterThan(before * after, vec2(0.0f)));
    vec2 weight = abs(before) + abs(after);  // of the axis across the edge
    weight *= weight;
    return 1.0f - 4.0f * dot(weight, part * part) / max(weight.x + weight.y, 1e-12f);
}

// What the filter changes of a pixel, relative to its result.
float shareOfEdge(vec2 before, vec2 after, float contrast) {
    float most = (VARIANT & EDGES_OF_SAMPLES) != 0 ? EDGE_SHARE_OF_SAMPLES : 1.0f;
    return most * unsmoothed(before, after, contrast);
}
