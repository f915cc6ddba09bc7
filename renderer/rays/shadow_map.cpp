#include "rays/shadow_map.h"

#include "image/bands.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory::rays {
namespace {

// Texels along the edge of a block. The texels that follow its last ones belong to it as well, so
// that the four about a place are always in the block of the first.
constexpr std::uint32_t kEdge = 8;

std::uint32_t blocksAlong(std::uint32_t texels) {
    return (texels + kEdge - 1) / kEdge;
}

// What is drawn first: all light passes, and no surface is nearer than its depth of 0.
constexpr std::uint64_t kClear = 0x0000'3c00'3c00'3c00;

// The four texels about a place in a map of that size, clamped to its edges. x, y: 0..1.
struct Corners {
    std::uint32_t width;
    std::uint32_t x0, y0, x1, y1;
    float fx, fy;

    Corners(float x, float y, std::uint32_t width, std::uint32_t height) : width(width) {
        const auto w = static_cast<float>(width), h = static_cast<float>(height);
        const float px = std::clamp(x * w - 0.5f, 0.0f, w - 1.0f);
        const float py = std::clamp(y * h - 0.5f, 0.0f, h - 1.0f);
        x0 = static_cast<std::uint32_t>(px);
        y0 = static_cast<std::uint32_t>(py);
        x1 = std::min(x0 + 1, width - 1);
        y1 = std::min(y0 + 1, height - 1);
        fx = px - static_cast<float>(x0);
        fy = py - static_cast<float>(y0);
    }

    std::size_t block() const { return std::size_t{y0 / kEdge} * blocksAlong(width) + x0 / kEdge; }
    // valueOf: of the texel of a number, first row first.
    template <class ValueOf>
    auto interpolated(ValueOf valueOf) const {
        const auto at = [&](std::uint32_t i, std::uint32_t j) {
            return valueOf(std::size_t{j} * width + i);
        };
        return (at(x0, y0) * (1.0f - fx) + at(x1, y0) * fx) * (1.0f - fy) +
               (at(x0, y1) * (1.0f - fx) + at(x1, y1) * fx) * fy;
    }
};

// Calls use(block, first x, end of x, first y, end of y) for each block of a map, from several
// threads.
template <class Use>
void forEachBlock(std::uint32_t width, std::uint32_t height, const Use& use) {
    forEachBand(blocksAlong(height), 8, [&](std::uint32_t row, std::uint32_t end) {
        for (; row < end; ++row) {
            const std::uint32_t y = row * kEdge;
            for (std::uint32_t column = 0; column < blocksAlong(width); ++column) {
                const std::uint32_t x = column * kEdge;
                use(std::size_t{row} * blocksAlong(width) + column, x,
                    std::min(x + kEdge + 1, width), y, std::min(y + kEdge + 1, height));
            }
        }
    });
}

// The plane is that of least squares, or constant if its bounds are closer then. depths: of the
// first texel; stride: from one row to the next.
ShadowMap::Block blockOf(const float* depths, std::size_t stride, int columns, int rows) {
    float sum[2] = {0.0f, 0.0f};
    float least = depths[0], most = depths[0];
    const float middleX = 0.5f * static_cast<float>(columns - 1),
                middleY = 0.5f * static_cast<float>(rows - 1);
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            const float d =
                depths[static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x)];
            sum[0] += (static_cast<float>(x) - middleX) * d;
            sum[1] += (static_cast<float>(y) - middleY) * d;
            least = std::min(least, d);
            most = std::max(most, d);
        }
    }
    if (least == most) return {least, most, 0.0f, 0.0f};
    // Sum of the squares of 0..n-1 less their mean.
    const auto squares = [](int n) { return static_cast<float>(n * (n * n - 1)) / 12.0f; };
    const auto slope = [&](float s, int along, int across) {
        return along > 1 ? s / (squares(along) * static_cast<float>(across)) : 0.0f;
    };
    const float dx = slope(sum[0], columns, rows), dy = slope(sum[1], rows, columns);
    float low = depths[0], high = depths[0];
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            const float d =
                depths[static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x)];
            const float rest = d - (dx * static_cast<float>(x) + dy * static_cast<float>(y));
            low = std::min(low, rest);
            high = std::max(high, rest);
        }
    }
    if (!(high - low < most - least)) return {least, most, 0.0f, 0.0f};
    // Both sides of a comparison are rounded.
    const float rounding =
        1e-6f * (std::max(std::fabs(low), std::fabs(high)) +
                 static_cast<float>(kEdge + 1) * (std::fabs(dx) + std::fabs(dy)));
    return {low - rounding, high + rounding, dx, dy};
}

}  // namespace

float ShadowMap::depthAt(float x, float y) const {
    const auto w = static_cast<int>(width), h = static_cast<int>(height);
    const int i = std::clamp(static_cast<int>(x * static_cast<float>(w)), 0, w - 1);
    const int j = std::clamp(static_cast<int>(y * static_cast<float>(h)), 0, h - 1);
    return depths[static_cast<std::size_t>(j) * width + static_cast<std::size_t>(i)];
}

float ShadowMap::lit(float x, float y, float depth) const {
    const Corners corners(x, y, width, height);
    if (!blocks.empty()) {
        const auto& [low, high, dx, dy] = blocks[corners.block()];
        const float plane = dx * static_cast<float>(corners.x0 % kEdge) +
                            dy * static_cast<float>(corners.y0 % kEdge);
        // The other corners are one texel on.
        const float rise = std::max(dx, 0.0f) + std::max(dy, 0.0f),
                    fall = std::min(dx, 0.0f) + std::min(dy, 0.0f);
        if (depth >= high + plane + rise) return 1.0f;
        if (depth < low + plane + fall) return 0.0f;
    }
    return corners.interpolated(
        [&](std::size_t texel) { return depth >= depths[texel] ? 1.0f : 0.0f; });
}

void ShadowMap::depthsAbout(float x, float y, float (&four)[4]) const {
    const Corners c(x, y, width, height);
    const float* lower = &depths[std::size_t{c.y0} * width];
    const float* upper = &depths[std::size_t{c.y1} * width];
    four[0] = upper[c.x0];
    four[1] = upper[c.x1];
    four[2] = lower[c.x1];
    four[3] = lower[c.x0];
}

void ShadowMap::tintAt(float x, float y, float (&rgba)[4]) const {
    const Corners corners(x, y, width / 2, height / 2);
    const bool clear = !clearBlocks.empty() && clearBlocks[corners.block()] != 0;
    const glm::vec4 tint =
        clear ? glm::vec4(1.0f, 1.0f, 1.0f, 0.0f) : corners.interpolated([&](std::size_t texel) {
            return glm::unpackHalf4x16(tints[texel]);
        });
    for (int i = 0; i < 4; ++i) rgba[i] = tint[i];
}

std::uint64_t ShadowMap::bytes() const {
    return depths.size() * sizeof(float) + tints.size() * sizeof(std::uint64_t) +
           blocks.size() * sizeof(Block) + clearBlocks.size();
}

void ShadowMap::summarize() {
    blocks.resize(std::size_t{blocksAlong(width)} * blocksAlong(height));
    forEachBlock(width, height,
                 [&](std::size_t block, std::uint32_t left, std::uint32_t right, std::uint32_t top,
                     std::uint32_t bottom) {
                     blocks[block] =
                         blockOf(&depths[std::size_t{top} * width + left], width,
                                 static_cast<int>(right - left), static_cast<int>(bottom - top));
                 });
    clearBlocks.clear();
    if (tints.empty()) return;
    const std::uint32_t tintsWidth = width / 2;
    clearBlocks.resize(std::size_t{blocksAlong(tintsWidth)} * blocksAlong(height / 2));
    forEachBlock(tintsWidth, height / 2,
                 [&](std::size_t block, std::uint32_t left, std::uint32_t right, std::uint32_t top,
                     std::uint32_t bottom) {
                     bool clear = true;
                     for (std::uint32_t y = top; clear && y < bottom; ++y) {
                         const std::uint64_t* row = &tints[std::size_t{y} * tintsWidth];
                         clear = std::all_of(row + left, row + right,
                                             [](std::uint64_t t) { return t == kClear; });
                     }
                     clearBlocks[block] = clear ? 1 : 0;
                 });
}

}  // namespace clerestory::rays
