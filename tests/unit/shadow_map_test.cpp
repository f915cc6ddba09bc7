// A summarized shadow map answers as its texels do, and mostly without them.
#include "rays/shadow_map.h"

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

using namespace clerestory;
using namespace clerestory::rays;

namespace {

constexpr std::uint64_t kNoTint = 0x0000'3c00'3c00'3c00;  // 1, 1, 1 and depth 0

// Inclined planes, steps between them, single texels that stand out, and nothing at all. Blocks do
// not divide its size.
ShadowMap mixedMap() {
    ShadowMap map{.width = 62, .height = 44};
    for (std::uint32_t y = 0; y < map.height; ++y) {
        for (std::uint32_t x = 0; x < map.width; ++x) {
            const auto u = static_cast<float>(x), v = static_cast<float>(y);
            float depth = 0.2f + 0.003f * u - 0.002f * v;
            if (x > 30 && y > 11) depth = 0.7f - 0.001f * u + 0.004f * v;
            if (x > 50) depth = 0.0f;
            if (x % 17 == 5 && y % 13 == 7) depth = 0.9f;
            map.depths.push_back(depth);
        }
    }
    const std::uint64_t red = glm::packHalf4x16({0.9f, 0.2f, 0.1f, 0.4f});
    for (std::uint32_t y = 0; y < map.height / 2; ++y) {
        for (std::uint32_t x = 0; x < map.width / 2; ++x) {
            map.tints.push_back(x > 8 && x < 20 && y > 5 && y < 9 ? red : kNoTint);
        }
    }
    return map;
}

class Places {
public:
    // A little beyond the map as well.
    glm::vec2 next() { return {uniform_(random_), uniform_(random_)}; }
    float depthAbout(float depth) { return depth + 0.02f * (uniform_(random_) - 0.5f); }

private:
    std::mt19937 random_{7};
    std::uniform_real_distribution<float> uniform_{-0.02f, 1.02f};
};

}  // namespace

TEST(ShadowMap, ASummaryChangesNothing) {
    const ShadowMap plain = mixedMap();
    ShadowMap summarized = plain;
    summarized.summarize();
    Places places;
    for (int i = 0; i < 200000; ++i) {
        const glm::vec2 at = places.next();
        const float there = plain.depthAt(at.x, at.y);
        for (const float depth : {there, places.depthAbout(there), 0.0f, 0.5f, 1.0f}) {
            ASSERT_EQ(summarized.lit(at.x, at.y, depth), plain.lit(at.x, at.y, depth))
                << at.x << ", " << at.y << ", depth " << depth;
        }
        std::array<float, 4> tint{}, expected{};
        summarized.tintAt(at.x, at.y, reinterpret_cast<float(&)[4]>(tint));
        plain.tintAt(at.x, at.y, reinterpret_cast<float(&)[4]>(expected));
        ASSERT_EQ(tint, expected) << at.x << ", " << at.y;
    }
}

// Without its texels a summarized map still knows what is in front of a plane and behind it.
TEST(ShadowMap, PlanesAndPlacesWithoutGlassNeedNoTexels) {
    ShadowMap map{.width = 64, .height = 64};
    for (int i = 0; i < 64 * 64; ++i) {
        map.depths.push_back(0.1f + 0.004f * static_cast<float>(i % 64) -
                             0.001f * static_cast<float>(i / 64));
    }
    map.tints.assign(std::size_t{32} * 32, kNoTint);
    map.summarize();
    std::fill(map.depths.begin(), map.depths.end(), 0.5f);
    std::fill(map.tints.begin(), map.tints.end(), 0);
    Places places;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec2 at = glm::clamp(places.next(), 0.01f, 0.99f);
        const float depth = 0.1f + 0.004f * (64.0f * at.x - 0.5f) - 0.001f * (64.0f * at.y - 0.5f);
        // The four texels about a place differ from it by less than the sum of both slopes.
        ASSERT_EQ(map.lit(at.x, at.y, depth + 0.0051f), 1.0f);
        ASSERT_EQ(map.lit(at.x, at.y, depth - 0.0051f), 0.0f);
        float tint[4];
        map.tintAt(at.x, at.y, tint);
        ASSERT_EQ(tint[0], 1.0f);
        ASSERT_EQ(tint[3], 0.0f);
    }
}
