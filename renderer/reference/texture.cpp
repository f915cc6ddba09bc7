#include "reference/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory::reference {
namespace {

// IEC 61966-2-1.
const std::array<double, 256>& linearFromSrgb() {
    static const std::array<double, 256> table = [] {
        std::array<double, 256> t{};
        for (int i = 0; i < 256; ++i) {
            const double s = i / 255.0;
            t[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
        }
        return t;
    }();
    return table;
}

std::uint32_t wrapped(double x, std::uint32_t size, Wrap wrap) {
    const double n = size;
    if (wrap == Wrap::clampToEdge) x = std::clamp(x, 0.0, n - 1.0);
    if (wrap == Wrap::repeat) x -= n * std::floor(x / n);
    if (wrap == Wrap::mirroredRepeat) {
        x -= 2.0 * n * std::floor(x / (2.0 * n));
        x = std::min(x, 2.0 * n - 1.0 - x);
    }
    // The clamp handles rounding of huge coordinates; NaN becomes 0.
    return x > 0.0 ? static_cast<std::uint32_t>(std::min(x, n - 1.0)) : 0;
}

glm::dvec4 texel(const TextureImage& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* t = image.texels.data() + 4 * (std::size_t{y} * image.width + x);
    if (image.colorSpace == ColorSpace::linear) return glm::dvec4(t[0], t[1], t[2], t[3]) / 255.0;
    const auto& linear = linearFromSrgb();
    return {linear[t[0]], linear[t[1]], linear[t[2]], t[3] / 255.0};
}

glm::dvec4 sampled(const Scene& scene, const Texture& texture, glm::dvec2 uv) {
    const TextureImage& image = scene.images[texture.image];
    const auto at = [&](double x, double y) {
        return texel(image, wrapped(x, image.width, texture.wrapU),
                     wrapped(y, image.height, texture.wrapV));
    };
    const glm::dvec2 size(image.width, image.height);
    if (texture.magnify == Filter::nearest) {
        const glm::dvec2 texel = glm::floor(uv * size);
        return at(texel.x, texel.y);
    }
    const glm::dvec2 position = uv * size - 0.5, corner = glm::floor(position),
                     fraction = position - corner;
    return glm::mix(
        glm::mix(at(corner.x, corner.y), at(corner.x + 1.0, corner.y), fraction.x),
        glm::mix(at(corner.x, corner.y + 1.0), at(corner.x + 1.0, corner.y + 1.0), fraction.x),
        fraction.y);
}

}  // namespace

glm::dvec4 textureAt(const Scene& scene, const TextureSlot& slot, const Vertex& a, const Vertex& b,
                     const Vertex& c, double weightB, double weightC) {
    if (!slot.present()) return glm::dvec4(1.0);
    const bool second = slot.texCoord == 1;
    const glm::dvec2 ua(second ? a.texCoord1 : a.texCoord0), ub(second ? b.texCoord1 : b.texCoord0),
        uc(second ? c.texCoord1 : c.texCoord0);
    const glm::dvec2 uv = ua * (1.0 - weightB - weightC) + ub * weightB + uc * weightC;
    // KHR_texture_transform: scale, rotate, translate. v points down, hence the signs of the
    // rotation.
    const glm::dvec2 scaled = uv * glm::dvec2(slot.scale);
    const double cosine = std::cos(slot.rotation), sine = std::sin(slot.rotation);
    const glm::dvec2 rotated(cosine * scaled.x + sine * scaled.y,
                             cosine * scaled.y - sine * scaled.x);
    return sampled(scene, scene.textures[slot.texture], rotated + glm::dvec2(slot.offset));
}

}  // namespace clerestory::reference
