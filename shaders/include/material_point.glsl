// A material at a point of a surface, and directions.
#ifndef CLERESTORY_MATERIAL_POINT_GLSL
#define CLERESTORY_MATERIAL_POINT_GLSL

// The type of a large parameter that is only read. Where these files are compiled as C++, a reference
// (renderer/rays/shader_code.h): copies were a sixth of the time of rays.
#ifndef IN
#define IN(type) type
#endif

// Layers over and in the surface; what a variant does not have, is not read.
struct Layers {
    float clearcoat;  // share of the surface
    float clearcoatRoughness;
    vec3 clearcoatNormal;  // unit, on the side that is seen
    vec3 sheen;
    float sheenRoughness;
    float film;  // share of the surface
    float filmIor;
    float filmThickness;  // nanometres
    float anisotropy;
    vec3 grain;    // direction in which the lobe is long, unit, in the surface
    vec3 through;  // albedo for diffuse light from the other side
    float throughShare;
};

Layers noLayers() {
    return Layers(0.0f, 0.0f, vec3(0.0f), vec3(0.0f), 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, vec3(0.0f),
                  vec3(0.0f), 0.0f);
}

// What a material says about a point of a surface, however the point was reached.
struct MaterialPoint {
    vec4 baseColor;  // w: coverage
    float metallic;
    float roughness;
    vec3 dielectricF0;  // at normal incidence, of the dielectric part; scaled by `specular`
    float specular;     // of the dielectric lobe at every angle (KHR_materials_specular)
    float grazing;      // what that lobe reflects edge-on
    float twoSided;     // 1 if both sides are drawn, else 0
    vec3 normal;        // unit, bumps included, on the side that is seen
    float occlusion;    // of indirect light
    vec3 emitted;       // added after everything else; only a coat dims it
    Layers layers;
};

// Squared lengths below this are no direction.
const float kNoDirection = 1e-20f;
vec3 direction(vec3 v) {
    return v * inversesqrt(max(dot(v, v), kNoDirection));
}

// The grain of a texel that turns `along`, the cosine and sine of the material's rotation.
vec2 grainOf(vec2 along, vec2 texel) {
    vec2 turned = texel * 2.0f - 1.0f;
    return vec2(along.x * turned.x - along.y * turned.y, along.y * turned.x + along.x * turned.y);
}

// In the surface with this unit normal; any direction there without tangents.
vec3 grainDirection(vec3 normal, vec3 tangent, vec3 bitangent, vec2 along) {
    vec3 grain = tangent * along.x + bitangent * along.y;
    grain -= normal * dot(grain, normal);
    vec3 other = abs(normal.x) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
    other -= normal * dot(other, normal);
    return direction(dot(grain, grain) > 1e-12f ? grain : other);
}

// Of a texel of TextureImage::packedNormal: unit, in tangent space.
vec3 unpackedNormal(vec4 texel) {
    vec2 slope = texel.ra * 2.0f - 1.0f;
    return vec3(slope, sqrt(max(1.0f - dot(slope, slope), 0.0f)));
}

// How far half vectors turn relative to the normal over a pixel, along two directions across it.
struct Turn {
    // In all, and only as far as the normal turns alike on both sides: at the edge of a bump the levels
    // of a normal map have normals between both sides that the surface hardly has.
    vec3 wholeX, wholeY;
    vec3 steadyX, steadyY;
};
Turn evenTurn(vec3 x, vec3 y) {
    return Turn(x, y, x, y);
}
Turn widened(Turn t, vec3 x, vec3 y) {
    return Turn(t.wholeX + x, t.wholeY + y, t.steadyX + x, t.steadyY + y);
}
Turn scaled(Turn t, float factor) {
    return Turn(factor * t.wholeX, factor * t.wholeY, factor * t.steadyX, factor * t.steadyY);
}

// Above it a highlight is so wide that the bumps within a pixel hardly change it; above twice that, as
// wide as that one point of a bumpy surface will do.
const float kGlintRoughness = 0.25f;

vec3 steadyOf(vec3 back, vec3 ahead) {
    vec3 less = dot(back, back) < dot(ahead, ahead) ? back : ahead;
    return dot(back, ahead) > 0.0f ? less : vec3(0.0f);
}

// Normals of a map here, and a pixel before and after it in each direction. x, y: the turn of the
// surface without bumps, which the map of a coarse mesh may undo.
Turn bumpyTurn(vec3 x, vec3 y, vec3 here, vec3 beforeX, vec3 afterX, vec3 beforeY, vec3 afterY) {
    return Turn(x + 0.5f * (afterX - beforeX), y + 0.5f * (afterY - beforeY),
                steadyOf(x + here - beforeX, x + afterX - here),
                steadyOf(y + here - beforeY, y + afterY - here));
}

#endif
