// Noise from integer hashes only: the texels do not depend on the math library.
#include "scene/builtin/textures.h"

#include "scene/image_levels.h"

#include <cmath>

namespace clerestory::textures {

float hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    return static_cast<float>(h >> 8) / 16777216.0f;
}

float noise(float x, float y, int period, int octaves, std::uint32_t seed) {
    float sum = 0.0f, weight = 0.5f, total = 0.0f;
    for (int o = 0; o < octaves; ++o, period *= 2, weight *= 0.5f) {
        const float fx = x * static_cast<float>(period), fy = y * static_cast<float>(period);
        const float ix = std::floor(fx), iy = std::floor(fy);
        const auto wrap = [&](float v) {
            return static_cast<std::uint32_t>((static_cast<int>(v) % period + period) % period);
        };
        const std::uint32_t x0 = wrap(ix), x1 = wrap(ix + 1), y0 = wrap(iy), y1 = wrap(iy + 1);
        const auto ease = [](float t) { return t * t * (3.0f - 2.0f * t); };
        const float tx = ease(fx - ix), ty = ease(fy - iy);
        const std::uint32_t s = seed + static_cast<std::uint32_t>(o);
        const float upper = glm::mix(hash(x0, y0, s), hash(x1, y0, s), tx);
        const float lower = glm::mix(hash(x0, y1, s), hash(x1, y1, s), tx);
        sum += weight * glm::mix(upper, lower, ty);
        total += weight;
    }
    return sum / total;
}

Index add(Scene& scene, std::string name, std::uint32_t width, std::uint32_t height,
          ColorSpace space, const std::function<glm::vec4(float u, float v)>& color) {
    TextureImage image{
        .name = std::move(name), .width = width, .height = height, .colorSpace = space};
    image.texels.reserve(4ull * width * height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const glm::vec4 c = color((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                      (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
            for (int i = 0; i < 4; ++i) {
                image.texels.push_back(
                    static_cast<std::uint8_t>(std::lround(255.0f * glm::clamp(c[i], 0.0f, 1.0f))));
            }
        }
    }
    buildLevels(image);
    scene.images.push_back(std::move(image));
    scene.textures.push_back({.image = static_cast<Index>(scene.images.size() - 1)});
    return static_cast<Index>(scene.textures.size() - 1);
}

Index addConstant(Scene& scene, std::string name, float value) {
    return add(scene, std::move(name), 1, 1, ColorSpace::linear,
               [&](float, float) { return glm::vec4(glm::vec3(value), 1.0f); });
}

}  // namespace clerestory::textures
