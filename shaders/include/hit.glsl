// The surface point that a ray hits: the values that surface.vert and material.glsl compute for a
// pixel, read from tables, because no texture can be bound for it. VARIANT has the features that any
// surface of the scene has; others are left out. After trace.glsl and iorOfPath(), which returns the
// index of refraction of a body with dispersion. Compiled as GLSL and as C++ (renderer/rays/shader_code.h).
#include "include/ray.glsl"
#include "include/surface_light.glsl"

#define hitHas(feature) ((uint(VARIANT) & (feature)) != 0u)  // a macro as has() is
#define hitLayered(bit) ((HIT_LAYERS & (bit)) != 0u)

// How the normal changes over a triangle, without bumps.
struct NormalChange {
    vec3 edgeB, edgeC;  // of the triangle, from its first corner; the longer one has the length 1
    vec3 toB, toC;      // change of the normal along them
    float inverseEdge;  // 1 / metres of such a length
};

// Change of the normal per metre along d, a unit vector in the triangle's plane.
vec3 changeAlong(IN(NormalChange) n, vec3 d) {
    vec3 face = cross(n.edgeB, n.edgeC);
    float perSquare = n.inverseEdge / max(dot(face, face), 1e-12f);
    return (n.toB * dot(cross(d, n.edgeC), face) + n.toC * dot(cross(n.edgeB, d), face)) * perSquare;
}

// Root of the mean square over all directions.
float meanChange(IN(NormalChange) n) {
    vec3 face = cross(n.edgeB, n.edgeC);
    float sum = dot(n.toB, n.toB) * dot(n.edgeC, n.edgeC) + dot(n.toC, n.toC) * dot(n.edgeB, n.edgeB) -
                2.0f * dot(n.toB, n.toC) * dot(n.edgeB, n.edgeC);
    return sqrt(0.5f * max(sum, 0.0f) / max(dot(face, face), 1e-12f)) * n.inverseEdge;
}

// All vectors have the axes of eye space; `position` alone is relative to the hierarchy's origin and
// has the world's, as the traversal requires.
struct HitPoint {
    MaterialPoint material;
    vec3 position;
    float reach;      // greatest coordinate of the triangle's corners
    NormalChange change;
    float curvature;  // change of the normal per metre, without bumps
    bool bulges;      // towards the ray
    // Of bumps over the width of the cone, along either texture coordinate.
    Turn turn, clearcoatTurn;
    vec3 faceNormal;  // unit, of the triangle, against the ray
    bool front;
    int flags;        // TRACE_MASK ...
    float cutoff;     // coverage below which there is nothing
    int instance;
    int firstLight;
    int lights;
    vec4 glass;       // as in MaterialBlock, thickness in metres
    vec3 attenuation;
    SurfaceLight light;  // if VIEW_SURFACE_LIGHT
};

// ---- textures ----------------------------------------------------------------------------------

// Texels counted from a picture's corner, brought into it.
vec2 wrapped(vec2 texel, vec2 size, vec2 mode) {
    if (texel.x >= 0.0f && texel.y >= 0.0f && texel.x < size.x && texel.y < size.y) return texel;
    vec2 repeated = texel - size * floor(texel / size);
    vec2 twice = texel - 2.0f * size * floor(0.5f * texel / size);
    vec2 mirrored = min(twice, 2.0f * size - 1.0f - twice);
    vec2 inside = mix(mix(repeated, mirrored, greaterThan(mode, vec2(0.5f))), texel,
                      greaterThan(mode, vec2(1.5f)));
    return clamp(inside, vec2(0.0f), size - 1.0f);
}

vec4 texelOf(vec4 level, vec2 at, bool root) {
    vec4 texel = texelFetch(traceTexels,
                            int(level.x) * 4096 + int(level.y) + int(at.y * level.z + at.x));
    return root ? vec4(texel.rgb * texel.rgb, texel.a) : texel;
}

vec4 levelAtHit(vec4 level, vec2 uv, vec2 wrapping, bool smoothly, bool root) {
    vec2 at = uv * level.zw - (smoothly ? 0.5f : 0.0f);
    vec2 corner = floor(at);
    vec2 part = smoothly ? at - corner : vec2(0.0f);
    vec2 first = wrapped(corner, level.zw, wrapping);
    vec2 second = wrapped(corner + 1.0f, level.zw, wrapping);
    vec4 lower = mix(texelOf(level, first, root), texelOf(level, vec2(second.x, first.y), root),
                     part.x);
    vec4 upper = mix(texelOf(level, vec2(first.x, second.y), root), texelOf(level, second, root),
                     part.x);
    return mix(lower, upper, part.y);
}

// number: of the texture, from 1. footprint: of the ray's cone, in texture coordinates. blended:
// between levels, finer ones, as colours are for pixels; numbers take the nearest (gpu_scene.cpp).
vec4 textureAtHit(float number, vec2 uv, float footprint, bool blended) {
    int row = int(tracing.limits.y) + (int(number) - 1) * TRACE_TEXTURE_ROWS;
    vec4 about = texelFetch(traceMaterials, row);
    vec2 size = texelFetch(traceMaterials, row + 1).zw;
    float lod = log2(clamp(footprint * max(size.x, size.y), 1.0f, 65536.0f));
    if (blended) lod = max(lod - float(COLOR_LEVELS_BELOW), 0.0f);
    lod = min(lod, about.x - 1.0f);
    bool smoothly = mod(about.w, 2.0f) > 0.5f;
    bool root = about.w > 1.5f;
    int level = int(blended ? lod : lod + 0.5f);
    vec4 texel = levelAtHit(texelFetch(traceMaterials, row + 1 + level), uv, about.yz, smoothly, root);
    if (blended) {
        int next = int(min(float(level) + 1.0f, about.x - 1.0f));
        vec4 coarser = levelAtHit(texelFetch(traceMaterials, row + 1 + next), uv, about.yz, smoothly,
                                  root);
        texel = mix(texel, coarser, lod - float(level));
    }
    return texel;
}

// Texture coordinates at a hit, and how many of their units a metre of the surface covers.
struct HitCoordinates {
    vec2 uv0;
    vec2 uv1;
    float perMetre0;
    float perMetre1;
};

// Of the slot's two rows, the first.
int slotRow(int material, int slot) {
    return material + 2 * slot + (slot < BASE_SLOTS ? 6 : TRACE_LAYERS + 5 - 2 * BASE_SLOTS);
}

// White where the material's slot has no texture.
vec4 slotAtHit(int material, int slot, HitCoordinates c, float width, bool blended) {
    vec4 uRow = texelFetch(traceMaterials, slotRow(material, slot));
    vec4 vRow = texelFetch(traceMaterials, slotRow(material, slot) + 1);
    if (vRow.w < 0.5f) return vec4(1.0f);
    vec2 uv = c.uv0;
    float perMetre = c.perMetre0;
    if (hitHas(FEATURE_SECOND_TEXCOORD)) {
        uv = uRow.w > 0.5f ? c.uv1 : uv;
        perMetre = uRow.w > 0.5f ? c.perMetre1 : perMetre;
    }
    if (hitHas(FEATURE_TEXTURE_TRANSFORM)) {
        uv = vec2(dot(uRow.xyz, vec3(uv, 1.0f)), dot(vRow.xyz, vec3(uv, 1.0f)));
        perMetre *= sqrt(abs(uRow.x * vRow.y - uRow.y * vRow.x));
    }
    return textureAtHit(vRow.w, uv, width * perMetre, blended);
}

// ---- vertices ----------------------------------------------------------------------------------

vec2 vertexPair(int vertex, int pair) {
    return texelFetch(traceVertices, TRACE_VERTEX_PAIRS * vertex + pair).xy;
}

vec3 vertexNormalOf(int vertex) {
    return vec3(vertexPair(vertex, 1).y, vertexPair(vertex, 2));
}

vec4 vertexTangentOf(int vertex) {
    return vec4(vertexPair(vertex, 3), vertexPair(vertex, 4));
}

vec4 vertexColorOf(int vertex) {
    return vec4(vertexPair(vertex, 7), vertexPair(vertex, 8));
}

vec3 times(vec4 row0, vec4 row1, vec4 row2, vec3 v) {
    return vec3(dot(row0.xyz, v), dot(row1.xyz, v), dot(row2.xyz, v));
}

// Length of the cross product of two texture edges, against that of the edges themselves.
float unitsPerMetre(vec2 a, vec2 b, vec2 c, float twiceArea) {
    vec2 e1 = b - a;
    vec2 e2 = c - a;
    return sqrt(abs(e1.x * e2.y - e1.y * e2.x) / max(twiceArea, 1e-30f));
}

SurfaceLight lightOfValue(int value) {
    SurfaceLight light = surfaceLightOf(surfaceLightRow(value, 0), surfaceLightRow(value, 1));
    if (viewHas(VIEW_EMITTERS)) {
        light = withEmitters(light, surfaceLightRow(value, SURFACE_LIGHT_ROWS));
    }
    return light;
}

// Of an instance whose values begin at `first`.
SurfaceLight lightAtHit(float first, int a, int b, int c, vec3 weights) {
    SurfaceLight la = lightOfValue(surfaceLightValue(first, a));
    SurfaceLight lb = lightOfValue(surfaceLightValue(first, b));
    SurfaceLight lc = lightOfValue(surfaceLightValue(first, c));
    SurfaceLight light;
    light.irradiance = la.irradiance * weights.x + lb.irradiance * weights.y + lc.irradiance * weights.z;
    light.turned = la.turned * weights.x + lb.turned * weights.y + lc.turned * weights.z;
    light.visible = la.visible * weights.x + lb.visible * weights.y + lc.visible * weights.z;
    light.nearby = la.nearby * weights.x + lb.nearby * weights.y + lc.nearby * weights.z;
    light.sides = la.sides * weights.x + lb.sides * weights.y + lc.sides * weights.z;
    light.emitted = la.emitted * weights.x + lb.emitted * weights.y + lc.emitted * weights.z;
    light.emittedFlux =
        la.emittedFlux * weights.x + lb.emittedFlux * weights.y + lc.emittedFlux * weights.z;
    return light;
}

// ---- bumps -------------------------------------------------------------------------------------

// The tangent frame of a normal map, not unit, and the map's scale.
struct BumpFrame {
    vec3 n, t, b;
    float scale;
    bool isPacked;
};

// metres: from the hit, along either texture coordinate.
vec3 bumpedAtHit(int m, int slot, BumpFrame frame, HitCoordinates uv, vec2 metres, float footprint) {
    uv.uv0 += metres * uv.perMetre0;
    uv.uv1 += metres * uv.perMetre1;
    vec4 texel = slotAtHit(m, slot, uv, footprint, false);
    vec3 bump = frame.isPacked ? unpackedNormal(texel) : texel.xyz * 2.0f - 1.0f;
    return direction(frame.t * (frame.scale * bump.x) + frame.b * (frame.scale * bump.y) +
                     frame.n * bump.z);
}

// here: the normal at the hit.
Turn turnAtHit(int m, int slot, BumpFrame frame, HitCoordinates uv, vec3 here, float footprint) {
    vec2 x = vec2(footprint, 0.0f);
    vec2 y = vec2(0.0f, footprint);
    return bumpyTurn(vec3(0.0f), vec3(0.0f), here, bumpedAtHit(m, slot, frame, uv, -x, footprint),
                     bumpedAtHit(m, slot, frame, uv, x, footprint),
                     bumpedAtHit(m, slot, frame, uv, -y, footprint),
                     bumpedAtHit(m, slot, frame, uv, y, footprint));
}

// ---- layers ------------------------------------------------------------------------------------

// normal: of the base; n, t, bitangentSign: of the mesh, n not unit.
Layers layersAtHit(int m, HitCoordinates uv, float footprint, vec3 normal, vec3 n, vec3 t,
                   float bitangentSign, bool front) {
    Layers l = noLayers();
    int row = m + TRACE_LAYERS;
    if (hitLayered(LAYER_CLEARCOAT)) {
        vec4 coat = texelFetch(traceMaterials, row);
        l.clearcoat = coat.x;
        l.clearcoatRoughness = coat.y;
        if (hitLayered(LAYER_CLEARCOAT_MAP)) {
            l.clearcoat *= slotAtHit(m, SLOT_CLEARCOAT, uv, footprint, false).r;
        }
        if (hitLayered(LAYER_CLEARCOAT_ROUGHNESS_MAP)) {
            l.clearcoatRoughness *=
                slotAtHit(m, SLOT_CLEARCOAT_ROUGHNESS, uv, footprint, false).g;
        }
        vec3 coatNormal = n;
        bool bumpy = texelFetch(traceMaterials, slotRow(m, SLOT_CLEARCOAT_NORMAL) + 1).w > 0.5f;
        if (hitLayered(LAYER_CLEARCOAT_NORMAL_MAP) && bumpy) {
            BumpFrame frame = BumpFrame(n, t, cross(n, t) * bitangentSign, coat.z, false);
            coatNormal = bumpedAtHit(m, SLOT_CLEARCOAT_NORMAL, frame, uv, vec2(0.0f), footprint);
        }
        coatNormal = direction(coatNormal);
        l.clearcoatNormal = front ? coatNormal : -coatNormal;
    }
    if (hitLayered(LAYER_SHEEN)) {
        vec4 sheen = texelFetch(traceMaterials, row + 1);
        l.sheen = sheen.rgb;
        l.sheenRoughness = sheen.w;
        if (hitLayered(LAYER_SHEEN_COLOR_MAP)) {
            l.sheen *= slotAtHit(m, SLOT_SHEEN_COLOR, uv, footprint, true).rgb;
        }
        if (hitLayered(LAYER_SHEEN_ROUGHNESS_MAP)) {
            l.sheenRoughness *= slotAtHit(m, SLOT_SHEEN_ROUGHNESS, uv, footprint, false).a;
        }
    }
    if (hitLayered(LAYER_IRIDESCENCE)) {
        vec4 film = texelFetch(traceMaterials, row + 2);
        l.film = film.x;
        l.filmIor = film.y;
        l.filmThickness = film.w;
        if (hitLayered(LAYER_IRIDESCENCE_MAP)) {
            l.film *= slotAtHit(m, SLOT_IRIDESCENCE, uv, footprint, false).r;
        }
        if (hitLayered(LAYER_IRIDESCENCE_THICKNESS_MAP)) {
            float part = slotAtHit(m, SLOT_IRIDESCENCE_THICKNESS, uv, footprint, false).g;
            l.filmThickness = mix(film.z, film.w, part);  // without a texture: 1
        }
    }
    if (hitLayered(LAYER_ANISOTROPY)) {
        vec4 anisotropy = texelFetch(traceMaterials, row + 3);
        l.anisotropy = anisotropy.x;
        vec2 along = vec2(anisotropy.y, anisotropy.z);
        bool mapped = texelFetch(traceMaterials, slotRow(m, SLOT_ANISOTROPY) + 1).w > 0.5f;
        if (hitLayered(LAYER_ANISOTROPY_MAP) && mapped) {
            vec4 texel = slotAtHit(m, SLOT_ANISOTROPY, uv, footprint, false);
            l.anisotropy *= texel.b;
            along = grainOf(along, vec2(texel.x, texel.y));
        }
        l.grain = grainDirection(normal, t, cross(n, t) * bitangentSign, along);
    }
    if (hitLayered(LAYER_DIFFUSE_TRANSMISSION)) {
        vec4 through = texelFetch(traceMaterials, row + 4);
        l.through = through.rgb;
        l.throughShare = through.w;
        if (hitLayered(LAYER_DIFFUSE_TRANSMISSION_MAP)) {
            l.throughShare *= slotAtHit(m, SLOT_DIFFUSE_TRANSMISSION, uv, footprint, false).a;
        }
        if (hitLayered(LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP)) {
            l.through *= slotAtHit(m, SLOT_DIFFUSE_TRANSMISSION_COLOR, uv, footprint, true).rgb;
        }
    }
    return l;
}

// ---- the point ---------------------------------------------------------------------------------

// along: the ray's direction, unit. width: of its cone at the hit, metres.
HitPoint hitPoint(Hit hit, vec3 along, float width) {
    HitPoint p;
    int triangleRow = TRACE_TRIANGLE_ROWS * max(hit.triangle, 0);
    vec4 a = texelFetch(traceTriangles, triangleRow);
    vec4 b = texelFetch(traceTriangles, triangleRow + 1);
    vec4 c = texelFetch(traceTriangles, triangleRow + 2);
    float wb = hit.weights.x;
    float wc = hit.weights.y;
    float wa = 1.0f - wb - wc;
    p.instance = int(b.w);
    int vertexA = int(texelFetch(traceIndices, 3 * int(a.w)).x);
    int vertexB = int(texelFetch(traceIndices, 3 * int(a.w) + 1).x);
    int vertexC = int(texelFetch(traceIndices, 3 * int(a.w) + 2).x);
    int row = TRACE_INSTANCE_ROWS * p.instance;
    vec4 n0 = texelFetch(traceInstances, row);
    vec4 n1 = texelFetch(traceInstances, row + 1);
    vec4 n2 = texelFetch(traceInstances, row + 2);
    vec4 e0 = texelFetch(traceInstances, row + 3);
    vec4 e1 = texelFetch(traceInstances, row + 4);
    vec4 e2 = texelFetch(traceInstances, row + 5);
    int m = TRACE_MATERIAL_ROWS * int(n0.w);
    if (viewHas(VIEW_SURFACE_LIGHT)) {
        p.light = lightAtHit(texelFetch(traceInstances, row + 6).x, vertexA, vertexB, vertexC,
                             vec3(wa, wb, wc));
    }
    p.firstLight = int(n1.w);
    p.lights = int(n2.w);

    p.position = a.xyz * wa + b.xyz * wb + c.xyz * wc;
    vec3 greatest = max(abs(a.xyz), max(abs(b.xyz), abs(c.xyz)));
    p.reach = max(greatest.x, max(greatest.y, greatest.z));
    vec3 face = eyeAxes(cross(b.xyz - a.xyz, c.xyz - a.xyz));
    float twiceArea = length(face);
    bool seenTurning = dot(face, along) < 0.0f;  // its corners turn counter-clockwise
    p.faceNormal = (seenTurning ? face : -face) / max(twiceArea, 1e-30f);
    p.front = seenTurning == (e0.w > 0.0f);
    float footprint = width / max(abs(dot(p.faceNormal, along)), 0.1f);

    HitCoordinates uv = HitCoordinates(vec2(0.0f), vec2(0.0f), 0.0f, 0.0f);
    vec2 ta = vertexPair(vertexA, 5);
    vec2 tb = vertexPair(vertexB, 5);
    vec2 tc = vertexPair(vertexC, 5);
    uv.uv0 = ta * wa + tb * wb + tc * wc;
    uv.perMetre0 = unitsPerMetre(ta, tb, tc, twiceArea);
    if (hitHas(FEATURE_SECOND_TEXCOORD)) {
        ta = vertexPair(vertexA, 6);
        tb = vertexPair(vertexB, 6);
        tc = vertexPair(vertexC, 6);
        uv.uv1 = ta * wa + tb * wb + tc * wc;
        uv.perMetre1 = unitsPerMetre(ta, tb, tc, twiceArea);
    }

    vec4 emissive = texelFetch(traceMaterials, m + 2);
    vec4 surface = texelFetch(traceMaterials, m + 1);
    vec4 attenuation = texelFetch(traceMaterials, m + 5);
    p.flags = int(attenuation.w) | int(e2.w);
    p.attenuation = attenuation.rgb;
    p.glass = texelFetch(traceMaterials, m + 4);
    if (hitLayered(LAYER_DISPERSION)) {
        p.glass.y = iorOfPath(p.glass.y, texelFetch(traceMaterials, m + TRACE_LAYERS).w);
    }
    p.glass.z *= e1.w;
    p.cutoff = (p.flags & TRACE_MASK) != 0 ? emissive.w : -1.0f;
    if (hitHas(FEATURE_TRANSMISSION_MAP)) {
        p.glass.x *= slotAtHit(m, SLOT_TRANSMISSION, uv, footprint, false).r;
    }
    if (hitHas(FEATURE_THICKNESS_MAP)) {
        p.glass.z *= slotAtHit(m, SLOT_THICKNESS, uv, footprint, false).g;
    }

    MaterialPoint point;
    point.baseColor = texelFetch(traceMaterials, m);
    if (hitHas(FEATURE_BASE_COLOR_MAP)) {
        point.baseColor *= slotAtHit(m, UNIT_BASE_COLOR, uv, footprint, true);
    }
    if (hitHas(FEATURE_VERTEX_COLOR)) {
        point.baseColor *= vertexColorOf(vertexA) * wa + vertexColorOf(vertexB) * wb +
                           vertexColorOf(vertexC) * wc;
    }
    vec2 metallicRoughness = surface.xy;
    if (hitHas(FEATURE_METALLIC_ROUGHNESS_MAP)) {
        metallicRoughness *= slotAtHit(m, UNIT_METALLIC_ROUGHNESS, uv, footprint, false).bg;
    }
    point.metallic = clamp(metallicRoughness.x, 0.0f, 1.0f);
    point.roughness = clamp(metallicRoughness.y, 0.0f, 1.0f);
    vec4 dielectric = texelFetch(traceMaterials, m + 3);
    point.dielectricF0 = dielectric.rgb;
    point.specular = dielectric.w;
    // As materialBlock() has it.
    point.grazing = dielectric.w * min(9.0f * (p.glass.y - 1.0f) / (p.glass.y + 1.0f), 1.0f);
    point.twoSided = (p.flags & TRACE_DOUBLE_SIDED) != 0 ? 1.0f : 0.0f;
    if (hitLayered(LAYER_SPECULAR_MAP)) {
        float factor = slotAtHit(m, SLOT_SPECULAR, uv, footprint, false).a;
        point.dielectricF0 *= factor;
        point.specular *= factor;
        point.grazing *= factor;
    }
    if (hitLayered(LAYER_SPECULAR_COLOR_MAP)) {
        point.dielectricF0 *= slotAtHit(m, SLOT_SPECULAR_COLOR, uv, footprint, true).rgb;
    }

    vec3 normalA = direction(times(n0, n1, n2, vertexNormalOf(vertexA)));
    vec3 normalB = direction(times(n0, n1, n2, vertexNormalOf(vertexB)));
    vec3 normalC = direction(times(n0, n1, n2, vertexNormalOf(vertexC)));
    vec3 n = normalA * wa + normalB * wb + normalC * wc;
    vec3 edgeB = eyeAxes(b.xyz - a.xyz);
    vec3 edgeC = eyeAxes(c.xyz - a.xyz);
    float inverseEdge = 1.0f / max(max(length(edgeB), length(edgeC)), 1e-30f);
    p.change = NormalChange(edgeB * inverseEdge, edgeC * inverseEdge, normalB - normalA, normalC - normalA,
                            inverseEdge);
    p.curvature = meanChange(p.change);
    p.bulges = (dot(p.change.toB, edgeB) + dot(p.change.toC, edgeC) > 0.0f) == p.front;
    vec3 meshNormal = n;
    vec3 t = vec3(0.0f);
    float bitangentSign = 1.0f;
    if (hitHas(FEATURE_NORMAL_MAP) || hitLayered(LAYERS_WITH_TANGENTS)) {
        vec4 tangentA = vertexTangentOf(vertexA);
        t = direction(times(e0, e1, e2, tangentA.xyz)) * wa +
            direction(times(e0, e1, e2, vertexTangentOf(vertexB).xyz)) * wb +
            direction(times(e0, e1, e2, vertexTangentOf(vertexC).xyz)) * wc;
        bitangentSign = tangentA.w * e0.w;
    }
    p.turn = evenTurn(vec3(0.0f), vec3(0.0f));
    n = direction(n);
    bool hasBumps = texelFetch(traceMaterials, m + 7 + 2 * UNIT_NORMAL).w > 0.5f;
    if (hitHas(FEATURE_NORMAL_MAP) && hasBumps) {
        bool joined = hitHas(FEATURE_PACKED_NORMAL) && (p.flags & TRACE_PACKED_NORMAL) != 0;
        BumpFrame frame = BumpFrame(meshNormal, t, cross(meshNormal, t) * bitangentSign, surface.z, joined);
        n = bumpedAtHit(m, UNIT_NORMAL, frame, uv, vec2(0.0f), footprint);
        if (hitHas(FEATURE_LIGHTS) && point.roughness < kGlintRoughness) {
            p.turn = turnAtHit(m, UNIT_NORMAL, frame, uv, n, footprint);
        }
    }
    point.normal = p.front ? n : -n;
    point.layers = layersAtHit(m, uv, footprint, point.normal, meshNormal, t, bitangentSign, p.front);
    p.clearcoatTurn = evenTurn(vec3(0.0f), vec3(0.0f));
    if (hitLayered(LAYER_CLEARCOAT_NORMAL_MAP) && hitHas(FEATURE_LIGHTS)) {
        vec4 coat = texelFetch(traceMaterials, m + TRACE_LAYERS);
        bool coatHasBumps = texelFetch(traceMaterials, slotRow(m, SLOT_CLEARCOAT_NORMAL) + 1).w > 0.5f;
        if (coatHasBumps && point.layers.clearcoatRoughness < kGlintRoughness) {
            BumpFrame frame = BumpFrame(meshNormal, t, cross(meshNormal, t) * bitangentSign, coat.z, false);
            vec3 here = p.front ? point.layers.clearcoatNormal : -point.layers.clearcoatNormal;
            p.clearcoatTurn = turnAtHit(m, SLOT_CLEARCOAT_NORMAL, frame, uv, here, footprint);
        }
    }
    if (viewHas(VIEW_SURFACE_LIGHT)) p.light = lightOnSide(p.light, p.front, n);
    point.occlusion = 1.0f;
    if (hitHas(FEATURE_OCCLUSION_MAP)) {
        point.occlusion +=
            surface.w * (slotAtHit(m, UNIT_OCCLUSION, uv, footprint, false).r - 1.0f);
    }
    point.emitted = vec3(0.0f);
    if (hitHas(FEATURE_EMISSION)) {
        point.emitted = emissive.rgb;
        if (hitHas(FEATURE_EMISSIVE_MAP)) {
            point.emitted *= slotAtHit(m, UNIT_EMISSIVE, uv, footprint, true).rgb;
        }
    }
    p.material = point;
    return p;
}
