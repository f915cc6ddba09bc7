// Shadows of lamps, in tiles of one map of depths that lamps see. Depth is reversed: 1 at the lamp,
// 0 far away. Pictures of six about a lamp have the axes of eye space. Compiled as GLSL and as C++
// (renderer/rays/path.cpp).

// A receiver is moved off its surface by so many texels of the map.
const float kShadowOffset = 1.5f;

// Face of a cube about the lamp, its coordinates, 0..1, and the distance along its axis.
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

// The share of the lamp's light that reaches a surface. position: in eye space; place: of the lamp,
// or direction; first: the lamp's rows in the table.
vec3 shadowAt(vec3 position, vec3 normal, vec3 place, vec3 toLight, float metres, int first) {
    vec4 about = texelFetch(lightTable, first + 3);  // kind, texel: slope and metres, near
    vec4 tile = texelFetch(lightTable, first + 4);  // corner and edge, texels; half a texel of the edge
    vec3 p = position + normal * (kShadowOffset * (about.y * metres + about.z));
    vec2 at;
    float depth;
    bool inside = true;
    bool six = viewHas(VIEW_SHADOWS_SIX) || (!viewHas(VIEW_SHADOWS_ONE) && about.x > 1.5f);
    if (six) {
        vec4 face = shadowFace(p - place);
        float row = face.z > 2.5f ? 1.0f : 0.0f;
        at = clamp(face.xy, vec2(tile.w), vec2(1.0f - tile.w)) + vec2(face.z - 3.0f * row, row);
        depth = about.w / max(face.w, about.w);
    } else {
        vec4 clip = vec4(dot(texelFetch(lightTable, first + 5), vec4(p, 1.0f)),
                         dot(texelFetch(lightTable, first + 6), vec4(p, 1.0f)),
                         dot(texelFetch(lightTable, first + 7), vec4(p, 1.0f)),
                         dot(texelFetch(lightTable, first + 8), vec4(p, 1.0f)));
        at = clip.xy / max(clip.w, 1e-20f) * 0.5f + vec2(0.5f);
        depth = clip.z / max(clip.w, 1e-20f);
        inside = clip.w > 0.0f && at.x > tile.w && at.y > tile.w && at.x < 1.0f - tile.w &&
                 at.y < 1.0f - tile.w;
        at = clamp(at, vec2(tile.w), vec2(1.0f - tile.w));
    }
    float lit = 1.0f;
    // Sides that turn away from the lamp have nothing of it.
    if (dot(normal, toLight) > 0.0f && about.x > 0.5f) {
        lit = texture(shadowMap, vec3((tile.xy + at * tile.z) * view.shadows.xy, depth));
    }
    return vec3(inside ? lit : 1.0f);
}
