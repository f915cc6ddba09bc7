// Shadows of lights, from one map of depths with tiles for each light. Depth is reversed: 1 at the light,
// 0 far away. The six pictures around a light have the axes of eye space. Compiled as GLSL and as C++
// (renderer/rays/shader_code.h).

// A receiver is moved off its surface by this number of texels of the map. The lit side of a two-sided
// surface is in the map, that of a one-sided surface is not: its offset keeps contacts closed.
const float kTwoSidedShadowOffset = 1.5f, kOneSidedShadowOffset = 0.5f;

// Face of a cube about the light, its coordinates, 0..1, and the distance along its axis.
vec4 shadowFace(vec3 way) {
    vec3 a = abs(way);
    float axis = max(a.x, max(a.y, a.z));
    bool isX = a.x >= axis;
    bool isY = !isX && a.y >= axis;
    vec2 st = isX ? vec2(way.x > 0.0f ? -way.z : way.z, -way.y)
              : isY ? vec2(way.x, way.y > 0.0f ? way.z : -way.z)
                    : vec2(way.z > 0.0f ? way.x : -way.x, -way.y);
    float face = isX ? (way.x > 0.0f ? 0.0f : 1.0f)
                 : isY ? (way.y > 0.0f ? 2.0f : 3.0f)
                       : (way.z > 0.0f ? 4.0f : 5.0f);
    st = st / max(axis, 1e-30f) * 0.5f + vec2(0.5f);
    return vec4(st.x, st.y, face, axis);
}

// Where a point is in the pictures of a light.
struct ShadowPlace {
    vec2 at;  // of the map, 0..1
    float depth;
    bool inside;  // one of the pictures shows it
};

bool hasSixPictures(vec4 about) {
    return viewHas(VIEW_SHADOWS_SIX) || (!viewHas(VIEW_SHADOWS_ONE) && about.x > 2.5f);
}

// What shadowPlace() takes of a point (w: 1) or a way (w: 0) in eye space; it is linear. source:
// position of the light, whose rows begin at `first`.
vec4 shadowCoordinates(vec4 p, vec3 source, int first, bool six) {
    if (six) return vec4(p.xyz - source * p.w, 0.0f);
    return vec4(dot(texelFetch(lightTable, first + 5), p), dot(texelFetch(lightTable, first + 6), p),
                dot(texelFetch(lightTable, first + 7), p), dot(texelFetch(lightTable, first + 8), p));
}

// The finest of the nearer pictures of a light that shows a place.
struct NearPicture {
    vec4 part;  // from clip space of the whole picture to 0..1 of it; 0: none shows the place
    vec4 tile;  // corner and edge, texels; extent of a texel, metres
};
// c: in clip space of the whole picture; first: the light's rows.
NearPicture nearPicture(vec4 c, int first) {
    NearPicture found = NearPicture(vec4(0.0f), vec4(0.0f));
    for (int i = 0; i < NEAR_SHADOWS; ++i) {
        vec4 part = texelFetch(lightTable, first + NEAR_SHADOW_ROW + 2 * i);
        vec4 tile = texelFetch(lightTable, first + NEAR_SHADOW_ROW + 2 * i + 1);
        vec2 at = vec2(c.x * part.x + part.z, c.y * part.y + part.w);
        float edge = 3.0f / max(tile.z, 1.0f);
        if (min(at.x, at.y) > edge && max(at.x, at.y) < 1.0f - edge) {
            found.part = part;
            found.tile = tile;
        }
    }
    return found;
}
bool hasNearPictures(vec4 about) {
    return viewHas(VIEW_SHADOWS_NEAR) && about.x > 1.5f && about.x < 2.5f;
}
// found: the place in the whole picture.
ShadowPlace placeIn(NearPicture picture, vec4 c, ShadowPlace found) {
    if (picture.tile.z > 0.0f) {
        vec2 at = vec2(c.x * picture.part.x + picture.part.z, c.y * picture.part.y + picture.part.w);
        found.at = (vec2(picture.tile.x, picture.tile.y) + at * picture.tile.z) * view.shadows.xy;
        found.inside = true;
    }
    return found;
}

// first, about, tile: the light's rows.
ShadowPlace wholeShadowPlace(vec4 c, bool six, vec4 about, vec4 tile) {
    ShadowPlace found;
    vec2 at;
    found.inside = true;
    if (six) {
        vec4 face = shadowFace(c.xyz);
        float row = face.z > 2.5f ? 1.0f : 0.0f;
        at = clamp(face.xy, vec2(tile.w), vec2(1.0f - tile.w)) + vec2(face.z - 3.0f * row, row);
        found.depth = about.w / max(face.w, about.w);
    } else {
        at = c.xy / max(c.w, 1e-20f) * 0.5f + vec2(0.5f);
        found.depth = max(c.z / max(c.w, 1e-20f), 0.0f);
        found.inside = c.w > 0.0f && at.x > tile.w && at.y > tile.w && at.x < 1.0f - tile.w &&
                       at.y < 1.0f - tile.w;
        at = clamp(at, vec2(tile.w), vec2(1.0f - tile.w));
    }
    found.at = (tile.xy + at * tile.z) * view.shadows.xy;
    return found;
}
ShadowPlace shadowPlace(vec4 c, bool six, int first, vec4 about, vec4 tile) {
    ShadowPlace found = wholeShadowPlace(c, six, about, tile);
    if (hasNearPictures(about)) return placeIn(nearPicture(c, first), c, found);
    return found;
}

// Depths of four neighbouring texels that differ by more than this number of texels belong to two
// surfaces, and so do those that are not in one plane within this fraction of their difference.
const float kSteepest = 4.0f, kTwist = 0.02f;

// Distance from a light, to a constant, at a depth of its picture. metres: from the light to the
// receiver, 0 for a directional light.
float shadowMetres(float depth, float metres, vec4 about, vec4 disc) {
    return metres > 0.0f ? about.w / max(depth, 1e-20f) : -depth * disc.y;
}

// The share of a light where only some of the four texels about a place hide it. Next to a surface that
// it touches a receiver is farther from the light than the surface and nearer than the middles of some
// of its texels: the plane through the four depths decides. first: the light's rows.
float litBetweenTexels(ShadowPlace s, float lit, float metres, int first, vec4 about) {
    vec4 depths = textureGather(shadowDepths, s.at);
    float nearest = max(max(depths.x, depths.y), max(depths.z, depths.w));
    float farthest = min(min(depths.x, depths.y), min(depths.z, depths.w));
    float twist = abs(depths.x + depths.z - depths.y - depths.w);
    if (twist > kTwist * (nearest - farthest) + 1e-6f * nearest) return lit;
    vec4 disc = texelFetch(lightTable, first + 9);
    float range = shadowMetres(farthest, metres, about, disc) -
                  shadowMetres(nearest, metres, about, disc);
    if (range > kSteepest * (about.y * metres + about.z)) return lit;
    vec2 at = s.at / view.shadows.xy - vec2(0.5f);
    at -= floor(at);
    float plane = mix(mix(depths.w, depths.z, at.x), mix(depths.x, depths.y, at.x), at.y);
    return s.depth >= plane ? 1.0f : 0.0f;
}

// A blocker near the ray to the light's centre hides a part of its disc if its distance from that ray is
// at most the radius of the beam from the disc. The search radius is the width of the beam at a quarter
// of the distance or, for a directional light, a little more than the greatest one.
const float kShadowSearch = 3.0f, kSunSearch = 1.25f;
// Blockers differ in distance: those within the mean beam count if their own beam is at least this
// fraction of it.
const float kShadowSpread = 0.5f;

// Turned by the golden angle.
vec2 nextTurn(vec2 turn) {
    return vec2(turn.x * -0.7373688f - turn.y * 0.6754903f,
                turn.x * 0.6754903f + turn.y * -0.7373688f);
}

// The fraction of the disc of a light that is visible from a point with the coordinates c (percentage-
// closer soft shadows, Fernando 2005, with beams instead of fixed widths). lit: that of its centre.
float softShadow(vec4 c, vec3 source, vec3 toLight, float metres, int first, vec4 about, vec4 tile,
                 float lit) {
    bool six = hasSixPictures(about);
    vec4 disc = texelFetch(lightTable, first + 9);  // radius; metres per depth of one with a direction
    bool placed = metres > 0.0f;
    vec3 x = normalize(cross(toLight, abs(toLight.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f)
                                                            : vec3(1.0f, 0.0f, 0.0f)));
    vec4 alongX = shadowCoordinates(vec4(x, 0.0f), source, first, six);
    vec4 alongY = shadowCoordinates(vec4(cross(toLight, x), 0.0f), source, first, six);
    float reach = placed ? min(kShadowSearch * disc.x, metres) : kSunSearch * disc.x * disc.y;
    float count = view.shadows.z;
    vec2 turn = vec2(1.0f, 0.0f);
    float sum = 0.0f;
    float blockers = 0.0f;
    float pairs = 0.5f * count;
    for (float i = 0.0f; i < pairs; i += 0.5f) {
        float t = (floor(i) + 0.5f) / pairs;
        float away = reach * t * t * t;
        ShadowPlace s = shadowPlace(c + alongX * (away * turn.x) + alongY * (away * turn.y), six, first,
                                    about, tile);
        float blocker = texture(shadowDepths, s.at).r;
        float beam = placed ? disc.x * (blocker / max(s.depth, 1e-30f) - 1.0f)
                            : disc.x * disc.y * (blocker - s.depth);
        if (s.inside && blocker > s.depth && beam >= away) {
            sum += min(beam, reach);
            blockers += 1.0f;
        }
        turn = i - floor(i) < 0.25f ? -turn : nextTurn(-turn);
    }
    // Within a texel the edge is that of the light's centre.
    float width = sum / max(blockers, 1.0f);
    if (width > about.y * metres + about.z) {
        lit = 0.0f;
        for (float i = 0.5f; i < count; i += 1.0f) {
            float away = width * sqrt(i / count);
            ShadowPlace s = shadowPlace(c + alongX * (away * turn.x) + alongY * (away * turn.y), six,
                                        first, about, tile);
            float least = kShadowSpread * away / max(disc.x, 1e-30f);
            float depth = placed ? s.depth * (1.0f + least) : s.depth + least / max(disc.y, 1e-30f);
            lit += s.inside ? texture(shadowMap, vec3(s.at, depth)) : 1.0f;
            turn = nextTurn(turn);
        }
        lit /= count;
    }
    return lit;
}

// Tinted points are farther from the light than the glass. The factors allow for its depth in halves.
const float kBehindGlass = 0.998f, kBehindGlassOfSun = 6e-4f;

// The share of a punctual light that reaches a surface. position: in eye space; offset: its normal
// times the texels by which it is moved; source: position of the light, or its direction; first: the light's rows in
// the table.
vec3 shadowAt(vec3 position, vec3 offset, vec3 source, vec3 toLight, float metres, int first) {
    // Pictures (0: none, 1: one, 2: nearer ones too, 3: six), texel: slope and metres, near.
    vec4 about = texelFetch(lightTable, first + 3);
    vec4 tile = texelFetch(lightTable, first + 4);  // corner and edge, texels; a texel of the edge
    bool six = hasSixPictures(about);
    NearPicture picture;
    if (viewHas(VIEW_SHADOWS_NEAR)) {
        picture = NearPicture(vec4(0.0f), vec4(0.0f));
        if (hasNearPictures(about)) {
            picture = nearPicture(shadowCoordinates(vec4(position, 1.0f), source, first, six), first);
        }
        if (picture.tile.z > 0.0f) about.z = picture.tile.w;
    }
    vec3 p = position + offset * (about.y * metres + about.z);
    vec4 c = shadowCoordinates(vec4(p, 1.0f), source, first, six);
    ShadowPlace whole = wholeShadowPlace(c, six, about, tile);
    ShadowPlace s = whole;
    if (viewHas(VIEW_SHADOWS_NEAR)) {
        s = placeIn(picture, c, whole);
        whole.at *= vec2(view.sampling.y, view.sampling.z);  // as the map of tints has it
    }
    float lit = 1.0f;
    // Sides that face away from the light receive no light from it.
    if (dot(offset, toLight) > 0.0f && about.x > 0.5f) {
        lit = texture(shadowMap, vec3(s.at, s.depth));
        if (lit > 0.0f && lit < 1.0f) lit = litBetweenTexels(s, lit, metres, first, about);
        if (viewHas(VIEW_SHADOWS_SOFT) && texelFetch(lightTable, first + 9).x > 0.0f) {
            lit = softShadow(c, source, toLight, metres, first, about, tile, s.inside ? lit : 1.0f);
        }
    }
    if (viewHas(VIEW_SHADOWS_TINTED) && about.x > 0.5f && whole.inside && lit > 0.0f) {
        vec4 tint = texture(shadowTints, whole.at);
        bool behind = metres > 0.0f ? s.depth < tint.a * kBehindGlass : s.depth < tint.a - kBehindGlassOfSun;
        return lit * (behind ? min(radianceFinite(tint.rgb), vec3(1.0f)) : vec3(1.0f));
    }
    return vec3(s.inside ? lit : 1.0f);
}
