// The reflection in a surface: the environment map, or the picture that the plan had drawn for it.
// After lighting.glsl's Surface. All directions and positions are in eye space.

vec2 pictureCoordinate(vec2 pixel) {
    return pixel * reflection.picture.xy + reflection.picture.zw;
}

// Texture coordinate in the mirror's picture of the point that a ray from `position` hits after
// `metres`: the ray is mirrored at the plane, and its end projected.
vec2 mirroredCoordinate(vec3 position, vec3 towards, float metres) {
    vec3 behind = towards - 2.0f * dot(towards, reflection.normal.xyz) * reflection.normal.xyz;
    vec4 clip = view.clipFromEye * vec4(position + behind * metres, 1.0f);
    vec2 ndc = clip.xy / max(clip.w, 1e-6f * metres + 1e-30f);
    vec2 pixel = (clamp(ndc, -4.0f, 4.0f) * 0.5f + 0.5f) * view.picture.xy;
    return pictureCoordinate(pixel);
}

// Metres from the surface, which is `toSurface` metres away, to the object in the picture.
float beyondSurface(float share, float toSurface) {
    return max(share / view.picture.w - toSurface, 0.0f);
}

// Where in the mirror's picture the surface reads.
struct MirrorPlace {
    vec2 at;
    vec2 shift;    // of `at` from the surface's own pixel; see insideMirror()
    float first;   // stored distance of the picture's pixel; see distance_share.glsl
    float beyond;  // metres from the surface to the reflected object
    float level;   // of the blurred picture
    float blur;    // fraction of the level, 0..1, that leaves out the sky behind the foot of a wall
};

// Beyond the edges of the mirror its picture shows the space behind the plane, often the sky. The pixels
// of a picture of half the size reach across an edge: a wall that stands on the mirror would get a bright
// line at its foot. A place that mixes the sky is moved to the nearest object among the adjacent
// pixels, if that object all but touches the mirror; others keep their silhouettes before the sky.
const float kTouching = 1.05f;  // of the distance to the mirror
void insideMirror(inout MirrorPlace found, float toMirror) {
    const float kSky = 0.5f * kFarShare;
    vec2 size = vec2(textureSize(mirrorPicture, 0));
    vec2 pixel = floor(found.at * size) + 0.5f;
    vec4 mixed = textureGather(mirrorPicture, found.at, 3);
    bool sky = max(max(mixed.x, mixed.y), max(mixed.z, mixed.w)) > kSky;
    // Sharp mirrors have one level, and pixels that do not reach across an edge. The number is no
    // constant, so that the loop stays one, which is left at once where no pixel mixes the sky.
    int count = reflection.levels.x > 0.0f ? 9 : 0;
    float touching = min(kTouching * toMirror * view.picture.w, kSky);
    float nearest = touching;
    vec2 at = found.at;
    for (int i = 0; i < count && sky; ++i) {
        vec2 adjacent = (pixel + vec2(float(i % 3 - 1), float(i / 3 - 1))) / size;
        float share = textureLod(mirrorPicture, adjacent, 0.0f).a;
        at = share < nearest ? adjacent : at;
        nearest = min(nearest, share);
    }
    found.first = nearest < touching ? nearest : found.first;
    found.shift = at - found.at;
    found.at = at;
}

// An object is close to the mirror within this fraction of the distance to the mirror, and while the lobe is
// at most so many pixels of the picture wide there.
const float kClose = 0.1f;
const float kClosePixels = 2.0f;

// The pixels of the mirrored view coincide with those of this view. Blur depends on the distance
// between the mirror and the reflected object (erratum R4), which is stored in the picture's alpha.
MirrorPlace mirrorPlace(Surface s, vec3 position) {
    MirrorPlace found;
    found.at = pictureCoordinate(gl_FragCoord.xy);
    float toMirror = length(position);
    // One look-up is as wide as the lobe is across the plane of incidence.
    float alpha = roundLobe(s.normal, s.toEye, s.nDotV, s.roughness * s.roughness).alpha;
    // The distance of the reflected objects is estimated over half the width of the lobe. Over its full
    // width, the lower end of an object on the mirror would be mixed with the empty space behind the
    // plane.
    found.first = textureLod(mirrorPicture, found.at, 0.0f).a;
    insideMirror(found, toMirror);
    float first = beyondSurface(found.first, toMirror);
    float wide = min(0.5f * lobeLod(2.0f * alpha, reflection.levels.y * lobeReach(toMirror, first)),
                     reflection.levels.x);
    float mixed = textureLod(mirrorPicture, found.at, wide).a;
    found.beyond = beyondSurface(mixed, toMirror);
    // What is close to the mirror is as far as its own pixel says, and as sharp as it takes to leave out
    // the sky behind the foot of a wall: a little of that would be many times as far as the wall. The sky
    // raises the mean distance by up to kFarShare, other objects by less than 1.
    float apart = max(first / (kClose * max(toMirror, 1e-18f)),
                      2.0f * alpha * reflection.levels.y * lobeReach(toMirror, first) / kClosePixels);
    found.beyond = min(found.beyond, first * (1.0f + apart));
    float sky = clamp(mixed - found.first, 0.0f, 1.0f);
    float level = mirrorLod(sqrt(alpha), reflection.levels.y, toMirror, found.beyond);
    found.blur = 1.0f - sky * clamp(2.0f - apart, 0.0f, 1.0f);
    found.level = min(level, reflection.levels.x) * found.blur;
    return found;
}

// The lobe as a sum of mirrored directions about GGX half vectors, each blurred by its share of the
// lobe. Unlike a single look-up it is elongated at grazing angles. The distance of the reflected
// objects is assumed to be the same in the whole lobe.
vec3 flatMirrorLobe(Surface s, vec3 position, MirrorPlace found) {
    uint count = uint(reflection.levels.w);  // at least 1
    float alpha = s.roughness * s.roughness;
    float lod = min(lobeLod(2.0f * alpha * inversesqrt(reflection.levels.w),
                            reflection.levels.y * lobeReach(length(position), found.beyond)),
                    reflection.levels.x) *
                found.blur;
    mat3 eyeFromLobe = frameAbout(s.normal);
    vec3 sum = vec3(0.0f);
    float weights = 1e-6f;
    uint i = 0u;
    do {
        vec3 halfway = eyeFromLobe * ggxHalfVector(hammersley(i, count), alpha);
        vec3 towards = reflect(-s.toEye, halfway);
        float weight = max(dot(s.normal, towards), 0.0f);
        vec2 at = mirroredCoordinate(position, towards, found.beyond) + found.shift;
        sum += textureLod(mirrorPicture, at, lod).rgb * weight;
        weights += weight;
    } while (++i < count);
    return sum / weights;
}

vec3 flatMirror(Surface s, vec3 position) {
    MirrorPlace found = mirrorPlace(s, position);
    if (has(FEATURE_MIRROR_SAMPLES)) {
        return flatMirrorLobe(s, position, found);
    }
    if (has(FEATURE_NORMAL_MAP)) {
        found.at = mirroredCoordinate(position, reflect(-s.toEye, s.normal), found.beyond) + found.shift;
    }
    return textureLod(mirrorPicture, found.at, found.level).rgb;
}

// Metres from a probe's centre to the surface that its cube shows in a direction.
float probeDepth(vec3 towards) {
    return textureLod(environmentMap, towards, 0.0f).a / view.picture.w;
}

// Intersection of a ray with the depths of a probe: the first point along it that is farther from the
// probe than the probe's depth in that direction. Steps grow with the distance; the last is bisected.
const int kDepthSteps = 24;
const int kDepthHalvings = 6;
const float kVisible = 1.05f;  // times the depth: tolerance for slopes and for the owner's support
vec3 depthParallax(vec3 from, vec3 along) {
    float reach = 1.0f / view.picture.w;  // the scene's diagonal
    float before = 0.0f, after = reach;
    bool met = false;
    for (int i = 1; i <= kDepthSteps; ++i) {
        float part = float(i) / float(kDepthSteps);
        float t = reach * part * part * part;
        vec3 p = from + along * t;
        bool behind = length(p) > probeDepth(p);
        after = !met && behind ? t : after;
        met = met || behind;
        before = met ? before : t;
    }
    for (int i = 0; i < kDepthHalvings; ++i) {
        float t = 0.5f * (before + after);
        vec3 p = from + along * t;
        bool behind = length(p) > probeDepth(p);
        after = behind ? t : after;
        before = behind ? before : t;
    }
    return met ? from + along * after : along;
}

// Intersection of the ray with the box around the probe. The box has the world's axes; a row vector
// times a matrix is the product with its transpose.
vec3 boxAlong(vec3 from, vec3 towards) {
    mat3 eyeFromWorld = mat3(view.worldFromEye[0].xyz, view.worldFromEye[1].xyz,
                             view.worldFromEye[2].xyz);
    vec3 inBox = eyeFromWorld * boxParallax(from * eyeFromWorld, towards * eyeFromWorld,
                                            reflection.proxyMin.xyz, reflection.proxyMax.xyz);
    // The sky has no parallax.
    return textureLod(environmentMap, inBox, 0.0f).a < 0.5f * kFarShare ? inBox : towards;
}

vec3 probeAlong(vec3 position, vec3 towards, float roughness) {
    vec3 at = towards;
    vec3 from = position - reflection.center.xyz;
    if (has(FEATURE_PARALLAX)) at = boxAlong(from, towards);
    if (has(FEATURE_PARALLAX_DEPTH)) {
        // Points that the probe does not see have no useful depths around them.
        bool visible = length(from) < kVisible * probeDepth(from);
        at = visible ? depthParallax(from, towards) : boxAlong(from, towards);
    }
    return textureLod(environmentMap, at, roughness * reflection.levels.x).rgb;
}

vec3 ownMapAlong(vec3 towards, float roughness) {
    vec3 at = vec3(dot(reflection.ownFromMap[0].xyz, towards),
                   dot(reflection.ownFromMap[1].xyz, towards),
                   dot(reflection.ownFromMap[2].xyz, towards));
    return textureLod(environmentMap, at, roughness * reflection.levels.x).rgb *
           view.environment.y;
}

vec3 mapAlong(vec3 position, vec3 towards, float roughness) {
    if (has(FEATURE_MAP)) return ownMapAlong(towards, roughness);
    if (has(FEATURE_PROBE)) return probeAlong(position, towards, roughness);
    return environmentAlong(towards, roughness);
}

// At an angle the lobe of a rough surface is longer in the plane of incidence than across it, but maps
// are filtered for round lobes. Therefore it is a sum of look-ups along the plane, which is blended into
// the one of roundLobe() at steeper angles and on surfaces that are smoother or reflect little. Weights
// add up to one, so a uniform map is reproduced.
const vec2 kAtAngle = vec2(0.5f, 0.65f);      // n.v: the sum below the first, none above the second
const vec2 kRoughLobe = vec2(0.1f, 0.2f);     // roughness: none below the first, the sum above the second
const vec2 kReflective = vec2(0.05f, 0.08f);  // reflectance: likewise
vec3 longLobe(Surface s, vec3 position, vec3 single) {
    float part = (1.0f - smoothstep(kAtAngle.x, kAtAngle.y, s.nDotV)) *
                 smoothstep(kRoughLobe.x, kRoughLobe.y, s.roughness) *
                 smoothstep(kReflective.x, kReflective.y, maxComponent(s.reflectance));
    int count = part > 0.0f ? int(view.environment.w) : 0;  // idle lanes cost nothing
    vec3 side = direction(s.toEye - s.normal * dot(s.toEye, s.normal));
    vec3 sum = vec3(0.0f);
    float weights = 1e-6f;
    for (int i = 0; i < count; ++i) {
        LobePart p = partOfLobe(s.normal, side, s.toEye, s.roughness * s.roughness, i, count);
        sum += mapAlong(position, p.along, sqrt(p.alpha)) * p.weight;
        weights += p.weight;
    }
    return mix(single, sum / weights, part);
}

// The lobe of an anisotropic surface: half vectors tilted along the anisotropy by the quantiles of its
// slopes, each as wide as the lobe is across, or as the distance of neighbours.
const int kGrainSamples = 8;
vec3 grainRadiance(Surface s, vec3 position) {
    vec2 alphas = anisotropicAlphas(s.roughness * s.roughness, s.layers.anisotropy);
    float roughness = sqrt(max(alphas.y, 1.5f * alphas.x / float(kGrainSamples)));
    vec3 sum = vec3(0.0f);
    float weights = 1e-6f;
    for (int i = 0; i < kGrainSamples; ++i) {
        float t = (2.0f * float(i) + 1.0f) / float(kGrainSamples) - 1.0f;
        vec3 halfway = direction(s.normal + s.layers.grain * (alphas.x * t * inversesqrt(1.0f - t * t)));
        vec3 towards = reflect(-s.toEye, halfway);
        float weight = max(dot(s.normal, towards), 0.0f) * max(dot(s.toEye, halfway), 0.0f);
        sum += mapAlong(position, towards, min(roughness, s.roughness)) * weight;
        weights += weight;
    }
    return sum / weights;
}

// From a map: the environment's, a captured one or the material's own.
vec3 mappedRadiance(Surface s, vec3 position) {
    RoundLobe lobe = roundLobe(s.normal, s.toEye, s.nDotV, s.roughness * s.roughness);
    float roughness = sqrt(lobe.alpha);
    vec3 gathered = layered(LAYER_ANISOTROPY) ? grainRadiance(s, position)
                    : has(FEATURE_WIDE_LOBE)  ? harmonicsAlong(lobe.along, lobeBands(roughness))
                                              : mapAlong(position, lobe.along, roughness);
    if (has(FEATURE_MAP_SAMPLES) && !layered(LAYER_ANISOTROPY)) gathered = longLobe(s, position, gathered);
    // Other pictures already contain occlusion, or are the material's own.
    return has(FEATURE_PROBE | FEATURE_MAP) ? gathered : reachingSurface(s, lobe.along, gathered);
}

// By rays, or from a mirrored view.
vec3 picturedRadiance(Surface s, vec3 position) {
    return has(FEATURE_MIRROR) ? flatMirror(s, position) : tracedReflection(s, position);
}

vec3 reflectedRadiance(Surface s, vec3 position) {
    const uint kPicture = FEATURE_MIRROR | FEATURE_TRACED_REFLECTION;
    if (has(kPicture) && !layered(LAYER_CLEARCOAT_MIRRORS)) return picturedRadiance(s, position);
    return mappedRadiance(s, position);
}

// Mirrors and rays are for surfaces up to the first roughness; where a texture makes them rougher than
// the second, their lobe is as wide as harmonics are.
const vec2 kWidestPicture = vec2(0.5f, 0.6f);

// The share, 0..1, of what the surface reflects that a picture or a ray shows, with the emitters in it. Maps
// and the highlights of emitters show the rest. All of it with layers, because a coat shares the picture.
float picturedShare(Surface s) {
    if (has(FEATURE_PROBE)) return 1.0f;
    if (!has(FEATURE_MIRROR | FEATURE_TRACED_REFLECTION)) return 0.0f;
    if (layered(LAYER_SHEEN | LAYER_CLEARCOAT)) return 1.0f;
    return 1.0f - smoothstep(kWidestPicture.x, kWidestPicture.y, s.roughness);
}

vec3 harmonicsInLobe(Surface s) {
    RoundLobe lobe = roundLobe(s.normal, s.toEye, s.nDotV, s.roughness * s.roughness);
    return reachingSurface(s, lobe.along, harmonicsAlong(lobe.along, lobeBands(sqrt(lobe.alpha))));
}

// The surface of the coat alone.
Surface clearcoatOf(Surface s) {
    Surface coat = s;
    coat.normal = s.layers.clearcoatNormal;
    coat.nDotV = max(dot(coat.normal, s.toEye), kMinCosine);
    coat.roughness = s.layers.clearcoatRoughness;
    coat.f0 = kClearcoatF0;
    coat.f90 = vec3(1.0f);
    return coat;
}

// The reflection in the coat. below: the reflection in the base, which the coat shares if both reflect
// a picture: then the base is as smooth, and bumps are small.
vec3 clearcoatRadiance(Surface s, vec3 position, vec3 below) {
    const uint kPicture = FEATURE_MIRROR | FEATURE_TRACED_REFLECTION;
    if (has(kPicture)) {
        return layered(LAYER_CLEARCOAT_MIRRORS) ? picturedRadiance(clearcoatOf(s), position) : below;
    }
    RoundLobe lobe = lobeOfCoat(s);
    vec3 gathered = mapAlong(position, lobe.along, sqrt(lobe.alpha));
    return has(FEATURE_PROBE | FEATURE_MAP) ? gathered : reachingSurface(s, lobe.along, gathered);
}
