#include "passes/traced_texels.h"

#include "passes/blocks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

glm::uvec2 sizeOf(const TextureImage& image, std::uint32_t level) {
    return {std::max(1u, image.width >> level), std::max(1u, image.height >> level)};
}

// The first level that is at most `edge` texels wide and high.
std::uint32_t firstLevel(const TextureImage& image, std::uint32_t edge) {
    std::uint32_t level = 0;
    while (level + 1 < image.levels && std::max(image.width, image.height) >> level > edge) ++level;
    return level;
}

std::uint64_t texelsBelow(const Scene& scene, std::uint32_t edge) {
    std::uint64_t sum = 0;
    for (const TextureImage& image : scene.images) {
        for (std::uint32_t level = firstLevel(image, edge); level < image.levels; ++level) {
            const glm::uvec2 size = sizeOf(image, level);
            sum += std::uint64_t{size.x} * size.y;
        }
    }
    return sum;
}

std::array<std::uint8_t, 256> rootOfSrgb() {
    std::array<std::uint8_t, 256> table{};
    for (int i = 0; i < 256; ++i) {
        const double x = i / 255.0;
        const double linear = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
        table[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(linear)));
    }
    return table;
}

void takeRoots(std::span<std::byte> rgba) {
    static const std::array<std::uint8_t, 256> root = rootOfSrgb();
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 != 3) rgba[i] = std::byte{root[std::to_integer<std::uint8_t>(rgba[i])]};
    }
}

}  // namespace

TracedTexels tracedTexels(const Scene& scene, const std::vector<gl::Texture>& images) {
    std::uint32_t edge = 1u << 15;
    while (edge > 1 && texelsBelow(scene, edge) > kMaxTracedTexels) edge /= 2;

    TracedTexels result;
    result.bytes.resize(4 * std::max<std::uint64_t>(1, texelsBelow(scene, edge)));
    std::vector<std::vector<glm::vec4>> levelsOf(scene.images.size());
    std::size_t texel = 0;
    for (std::size_t i = 0; i < scene.images.size(); ++i) {
        const TextureImage& image = scene.images[i];
        for (std::uint32_t level = firstLevel(image, edge); level < image.levels; ++level) {
            const glm::uvec2 size = sizeOf(image, level);
            const std::size_t count = std::size_t{size.x} * size.y;
            const std::span<std::byte> texels =
                std::span(result.bytes).subspan(4 * texel, 4 * count);
            images[i].read(level, texels);
            if (image.colorSpace == ColorSpace::srgb) takeRoots(texels);
            levelsOf[i].emplace_back(texel / 4096, texel % 4096, size.x, size.y);
            texel += count;
        }
    }
    for (const Texture& texture : scene.textures) {
        const std::size_t first = result.rows.size();
        result.rows.resize(first + TRACE_TEXTURE_ROWS);
        const std::vector<glm::vec4>& levels = levelsOf[texture.image];
        const std::size_t count =
            texture.useLevels ? std::min<std::size_t>(levels.size(), TRACE_TEXTURE_ROWS - 1) : 1;
        const bool smooth = texture.magnify == Filter::linear;
        const bool root = scene.images[texture.image].colorSpace == ColorSpace::srgb;
        result.rows[first] = {count, static_cast<float>(texture.wrapU),
                              static_cast<float>(texture.wrapV),
                              (smooth ? 1.0f : 0.0f) + (root ? 2.0f : 0.0f)};
        std::copy_n(levels.begin(), count,
                    result.rows.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    }
    return result;
}

}  // namespace clerestory
