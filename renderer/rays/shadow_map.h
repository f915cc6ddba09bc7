// The shadow map of all lights (shaders/include/shadow.glsl), in main memory.
//
//     ShadowMap map{.width = 3074, .height = 3074, .depths = ..., .tints = ...};
//     map.summarize();  // if it will be read for several frames
//     const float share = map.lit(0.5f, 0.5f, 0.01f);
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace clerestory::rays {

struct ShadowMap {
    std::uint32_t width = 0, height = 0;
    std::vector<float> depths;  // reversed, first row first
    // Transmittance of glass and blended surfaces, red in the lowest bits of four halves, and their
    // depth; half as wide and high. Empty: there are no such surfaces.
    std::vector<std::uint64_t> tints;

    // Of the texel at a place, as lit().
    float depthAt(float x, float y) const;
    // Share, 0..1, of the four texels about a place that are not before `depth`, as a driver
    // filters it. x, y: 0..1 over the map, clamped to its edges.
    float lit(float x, float y, float depth) const;
    // Of the four texels about a place, clamped to the edges, in the order of textureGather(): of
    // the next row the left and the right one, of this row the right and the left one.
    void depthsAbout(float x, float y, float (&four)[4]) const;
    // Interpolated between the four texels about a place, clamped to the edges.
    void tintAt(float x, float y, float (&rgba)[4]) const;

    // Computes the members below from those above, about 1 ns a texel. They change no result: most
    // results follow from them alone, and they are small enough for the processor's caches.
    void summarize();
    std::uint64_t bytes() const;

    // Bounds of the depths of a square of texels: at x, y texels from its first one they are from
    // low + dx x + dy y to high + dx x + dy y.
    struct Block {
        float low, high, dx, dy;
    };
    std::vector<Block> blocks;              // of depths; empty: not summarized
    std::vector<std::uint8_t> clearBlocks;  // of tints: 1 if nothing is before the lights there
};

}  // namespace clerestory::rays
