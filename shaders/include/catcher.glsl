// A shadow catcher: the fraction of light that is missing compared with an open ground, and the
// reflection of the scene in it. After reflection.glsl.

float meanOf(vec3 c) {
    return (c.r + c.g + c.b) / 3.0f;
}

// Irradiance over pi of the lights with shadows, and without.
vec2 lightsOnGround(Surface s, vec3 position, int first, int count) {
    vec2 sum = vec2(0.0f);
    for (int i = 0; i < count; ++i) {
        int row = HARMONIC_ROWS + (first + i) * LIGHT_ROWS;
        ArrivingLight arriving = arrivingLight(s, position, row, true);
        if (arriving.nDotL > 0.0f && arriving.falloff > 0.0f) {
            vec3 light = arriving.power * (arriving.falloff * arriving.nDotL / kPi);
            sum.y += meanOf(light);
            if (viewHas(VIEW_SHADOWS)) {
                light *= shadowAt(position, s.shadowOffset * s.normal, arriving.source, arriving.toLight,
                                  arriving.metres, row);
            }
            sum.x += meanOf(light);
        }
    }
    return sum;
}

// The same for the surroundings. Visibility is linear in the direction: its cosine-weighted mean over
// the hemisphere is its value at 2/3 of the normal.
vec2 surroundingsOfGround(Surface s) {
    float open = max(meanOf(harmonicsAlong(s.normal, vec2(1.0f))), 0.0f);
    if (!viewHas(VIEW_SURFACE_LIGHT)) return vec2(open);
    float share =
        clamp(dot(s.light.visible.xyz, s.normal) * (2.0f / 3.0f) + s.light.visible.w, 0.0f, 1.0f);
    return vec2(open * share + meanOf(s.light.nearby) * (1.0f - share), open);
}

// What the mirrored view shows before black, and the share of it that is not empty. The picture's
// distances are means: near things and kFarShare, where nothing is. How far away near things are is
// known where they fill a pixel, and elsewhere they are about as far as the ground.
vec4 mirroredScene(Surface s, vec3 position) {
    MirrorPlace found = mirrorPlace(s, position);
    vec4 picture = textureLod(mirrorPicture, found.at, found.level);
    float near = found.first < 0.5f * kFarShare
                     ? found.first
                     : distanceShare(length(position), view.picture.w);
    float filled = (kFarShare - picture.a) / max(kFarShare - near, 1.0f);
    return vec4(picture.rgb, clamp(filled, 0.0f, 1.0f));
}

// Premultiplied: what is reflected, and what is left of the background.
vec4 caughtLight(Surface s, vec3 position, int firstLight, int lights) {
    vec2 light = surroundingsOfGround(s);
    if (has(FEATURE_LIGHTS)) light += lightsOnGround(s, position, firstLight, lights);
    float kept = light.y > 0.0f ? clamp(light.x / light.y, 0.0f, 1.0f) : 1.0f;
    vec4 mirrored = vec4(0.0f);
    if (has(FEATURE_MIRROR)) mirrored = mirroredScene(s, position);
    kept *= 1.0f - meanOf(s.reflectance) * mirrored.a;
    return vec4(s.reflectance * mirrored.rgb, 1.0f - kept);
}
