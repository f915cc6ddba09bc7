// The shadow map of all lights (shaders/include/shadow.glsl), in main memory.
#pragma once

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clerestory::rays {

// Between the four texels about a place in a map of that size, clamped to its edges. x, y: 0..1.
// valueOf: of the texel of a number, first row first.
template <class ValueOf>
auto interpolated(float x, float y, std::uint32_t width, std::uint32_t height, ValueOf valueOf) {
    const auto w = static_cast<int>(width), h = static_cast<int>(height);
    const float px = std::clamp(x * static_cast<float>(w) - 0.5f, 0.0f, float(w - 1));
    const float py = std::clamp(y * static_cast<float>(h) - 0.5f, 0.0f, float(h - 1));
    const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
    const int x1 = std::min(x0 + 1, w - 1), y1 = std::min(y0 + 1, h - 1);
    const float fx = px - static_cast<float>(x0), fy = py - static_cast<float>(y0);
    const auto at = [&](int i, int j) {
        return valueOf(static_cast<std::size_t>(j) * width + static_cast<std::size_t>(i));
    };
    return (at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx) * (1.0f - fy) +
           (at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx) * fy;
}

struct ShadowMap {
    std::uint32_t width = 0, height = 0;
    std::vector<float> depths;  // reversed, first row first
    // Transmittance of glass and blended surfaces, red in the lowest bits of four halves, and their
    // depth; half as wide and high. Empty: there are no such surfaces.
    std::vector<std::uint64_t> tints;

    // Of the texel at a place, as lit().
    float depthAt(float x, float y) const {
        const auto w = static_cast<int>(width), h = static_cast<int>(height);
        const int i = std::clamp(static_cast<int>(x * static_cast<float>(w)), 0, w - 1);
        const int j = std::clamp(static_cast<int>(y * static_cast<float>(h)), 0, h - 1);
        return depths[static_cast<std::size_t>(j) * width + static_cast<std::size_t>(i)];
    }
    // Share, 0..1, of the four texels about a place that are not before `depth`, as a driver
    // filters it. x, y: 0..1 over the map, clamped to its edges.
    float lit(float x, float y, float depth) const {
        return interpolated(x, y, width, height, [&](std::size_t texel) {
            return depth >= depths[texel] ? 1.0f : 0.0f;
        });
    }
    // Interpolated between the four texels about a place, clamped to the edges.
    void tintAt(float x, float y, float (&rgba)[4]) const {
        const glm::vec4 tint = interpolated(x, y, width / 2, height / 2, [&](std::size_t texel) {
            return glm::unpackHalf4x16(tints[texel]);
        });
        for (int i = 0; i < 4; ++i) rgba[i] = tint[i];
    }
};

}  // namespace clerestory::rays
