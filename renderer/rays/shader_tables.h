// The tables, textures and blocks that the includes of shaders/ read, in main memory, with GLSL's
// functions that read them. Tables are not checked: their rows belong together (Surroundings).
#pragma once

#include "rays/cube_map.h"
#include "rays/glsl.h"
#include "rays/shadow_map.h"
#include "rays/triangle_tree.h"
#include "shaders/include/bindings.glsl"

#include <cstddef>
#include <cstdint>

namespace clerestory::rays::shader {

using namespace clerestory::rays::glsl;

struct Rows {
    const float* data = nullptr;
};
struct Pairs {
    const float* data = nullptr;
};
struct Integers {
    const std::uint32_t* data = nullptr;
};
struct Quads {
    const std::uint32_t* data = nullptr;  // four each
};
struct Texels {
    const std::byte* data = nullptr;
};
struct Triangles {
    const TriangleTree* tree = nullptr;
};
struct Plane {
    const float* data = nullptr;  // two floats each
    int size = 0;
};
struct Cube {
    const CubeMap* map = nullptr;
};
struct Depths {
    const ShadowMap* map = nullptr;
};

struct RawDepths {
    const ShadowMap* map = nullptr;
};

struct Tints {
    const ShadowMap* map = nullptr;
};

struct Scene {
    struct {
        vec4 worldFromEye[3];
        vec4 environment;
        vec4 shadows;
        vec4 sampling;
    } viewBlock;
    struct {
        vec4 eye, limits, background;
    } tracingBlock;
    std::uint32_t features;
    std::uint32_t layers;
    std::uint32_t viewBits;
    Quads surfaceLight, emitters;
    Triangles triangles;
    Pairs vertices;
    Integers indices;
    Rows instances, materials, lights;
    Texels texels;
    Plane brdf;
    Cube environment;
    Depths shadowMap;
    RawDepths shadowDepths;
    Tints shadowTints;
};

inline vec4 texelFetch(Rows table, int i) {
    const float* row = table.data + std::size_t{4} * static_cast<std::size_t>(i);
    return {row[0], row[1], row[2], row[3]};
}
inline vec4 texelFetch(Pairs table, int i) {
    const float* pair = table.data + std::size_t{2} * static_cast<std::size_t>(i);
    return {pair[0], pair[1], 0.0f, 1.0f};
}
inline uvec4 texelFetch(Integers table, int i) {
    return {table.data[i], 0u, 0u, 1u};
}
inline uvec4 texelFetch(Quads table, int i) {
    const std::uint32_t* q = table.data + std::size_t{4} * static_cast<std::size_t>(i);
    return {q[0], q[1], q[2], q[3]};
}
inline vec4 texelFetch(Texels table, int i) {
    const auto* t = reinterpret_cast<const std::uint8_t*>(table.data) +
                    std::size_t{4} * static_cast<std::size_t>(i);
    constexpr float k = 1.0f / 255.0f;
    return {k * t[0], k * t[1], k * t[2], k * t[3]};
}
inline vec4 texelFetch(Triangles table, int row) {
    const auto triangle =
        static_cast<std::uint32_t>(row) / static_cast<std::uint32_t>(TRACE_TRIANGLE_ROWS);
    const auto* rows = reinterpret_cast<const float*>(&table.tree->triangle(triangle));
    return texelFetch(Rows{rows}, row - TRACE_TRIANGLE_ROWS * static_cast<int>(triangle));
}
// Bilinear, clamped to the edge.
inline vec4 textureLod(Plane plane, vec2 at, float) {
    const auto size = static_cast<float>(plane.size);
    const vec2 p = clamp(at * size - vec2(0.5f), vec2(0.0f), vec2(size - 1.0f));
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    const int x1 = min(x + 1, plane.size - 1), y1 = min(y + 1, plane.size - 1);
    const auto texel = [&](int i, int j) {
        const float* t = plane.data + 2 * (j * plane.size + i);
        return vec2(t[0], t[1]);
    };
    const float fx = p.x - static_cast<float>(x), fy = p.y - static_cast<float>(y);
    const vec2 value =
        mix(mix(texel(x, y), texel(x1, y), fx), mix(texel(x, y1), texel(x1, y1), fx), fy);
    return {value.x, value.y, 0.0f, 1.0f};
}
inline vec4 textureLod(Cube cube, vec3 towards, float level) {
    float rgb[3];
    cube.map->sample(&towards.x, level, rgb);
    return {rgb[0], rgb[1], rgb[2], 1.0f};
}
inline vec4 texture(RawDepths depths, vec2 at) {
    return {depths.map->depthAt(at.x, at.y), 0.0f, 0.0f, 1.0f};
}
inline vec4 textureGather(RawDepths depths, vec2 at) {
    float d[4];
    depths.map->depthsAbout(at.x, at.y, d);
    return {d[0], d[1], d[2], d[3]};
}
inline vec4 texture(Tints tints, vec2 at) {
    float rgba[4];
    tints.map->tintAt(at.x, at.y, rgba);
    return {rgba[0], rgba[1], rgba[2], rgba[3]};
}
inline float texture(Depths depths, vec3 at) {
    return depths.map->lit(at.x, at.y, at.z);
}

}  // namespace clerestory::rays::shader
