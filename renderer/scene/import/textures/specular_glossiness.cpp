#include "scene/import/textures/specular_glossiness.h"

#include "scene/srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

constexpr float kDielectric = 0.04f;  // reflectance

// Perceived brightness with the luma weights of Rec. 601, for metals and dielectrics.
float brightness(const glm::vec3& c) {
    return std::sqrt(glm::dot(glm::vec3(0.299f, 0.587f, 0.114f), c * c));
}

std::uint8_t byteOf(float share) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
}

}  // namespace

// The reflectance of the mixture is 0.04 (1 - m) + base m, its diffuse part base (1 - 0.04)
// (1 - m), which specular-glossiness has as diffuse (1 - max(specular)).
MetallicBase metallicBase(const glm::vec3& diffuse, const glm::vec3& specular) {
    const float remaining = 1.0f - std::max({specular.x, specular.y, specular.z});
    const float bright = brightness(specular);
    MetallicBase base;
    if (bright > kDielectric) {
        const float b =
            brightness(diffuse) * remaining / (1.0f - kDielectric) + bright - 2.0f * kDielectric;
        const float c = kDielectric - bright;
        const float root = std::sqrt(std::max(b * b - 4.0f * kDielectric * c, 0.0f));
        base.metallic = std::clamp((root - b) / (2.0f * kDielectric), 0.0f, 1.0f);
    }
    constexpr float kLeast = 1e-4f;  // keeps quotients finite
    const float m = base.metallic;
    const glm::vec3 ofDiffuse =
        diffuse * (remaining / (1.0f - kDielectric) / std::max(1.0f - m, kLeast));
    const glm::vec3 ofSpecular = (specular - kDielectric * (1.0f - m)) / std::max(m, kLeast);
    // Each is exact where it has all the weight.
    base.color = glm::clamp(glm::mix(ofDiffuse, ofSpecular, m * m), 0.0f, 1.0f);
    return base;
}

TextureImage converted(const TextureImage* diffuse, const TextureImage* specular,
                       const SpecularGlossinessFactors& factors, ConvertedTo result) {
    std::array<float, 256> linear{};
    for (int code = 0; code < 256; ++code)
        linear[static_cast<std::size_t>(code)] = linearFromSrgb(static_cast<float>(code) / 255.0f);
    TextureImage image;
    image.levels = image.width = image.height = 1;
    for (const TextureImage* source : {diffuse, specular}) {
        if (!source) continue;
        image.width = std::max(image.width, source->width);
        image.height = std::max(image.height, source->height);
    }
    image.texels.resize(std::size_t{4} * image.width * image.height);
    constexpr std::array<std::uint8_t, 4> kWhite{255, 255, 255, 255};
    const auto texel = [&](const TextureImage* source, std::uint32_t x, std::uint32_t y) {
        if (!source) return kWhite.data();
        const std::size_t column = std::uint64_t{x} * source->width / image.width;
        const std::size_t row = std::uint64_t{y} * source->height / image.height;
        return source->texels.data() + 4 * (row * source->width + column);
    };
    const auto color = [&](const std::uint8_t* t) {
        return glm::vec3(linear[t[0]], linear[t[1]], linear[t[2]]);
    };
    std::uint8_t* out = image.texels.data();
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x, out += 4) {
            const std::uint8_t *d = texel(diffuse, x, y), *s = texel(specular, x, y);
            const MetallicBase base =
                metallicBase(factors.diffuse * color(d), factors.specular * color(s));
            if (result == ConvertedTo::baseColor) {
                for (int k = 0; k < 3; ++k) out[k] = byteOf(srgbFromLinear(base.color[k]));
                out[3] = d[3];
            } else {
                out[0] = 255;
                out[1] = byteOf(1.0f - factors.glossiness * static_cast<float>(s[3]) / 255.0f);
                out[2] = byteOf(base.metallic);
                out[3] = 255;
            }
        }
    }
    return image;
}

}  // namespace clerestory
