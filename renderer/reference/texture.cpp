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

std::uint32_t wrapped(double place, std::uint32_t size, Wrap wrap) {
    const double n = size;
    if (wrap == Wrap::clampToEdge) place = std::clamp(place, 0.0, n - 1.0);
    if (wrap == Wrap::repeat) place -= n * std::floor(place / n);
    if (wrap == Wrap::mirroredRepeat) {
        place -= 2.0 * n * std::floor(place / (2.0 * n));
        place = std::min(place, 2.0 * n - 1.0 - place);
    }
    // The clamp is for what rounding leaves of huge coordinates; NaN becomes 0.
    return place > 0.0 ? static_cast<std::uint32_t>(std::min(place, n - 1.0)) : 0;
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
        const glm::dvec2 place = glm::floor(uv * size);
        return at(place.x, place.y);
    }
    const glm::dvec2 place = uv * size - 0.5, corner = glm::floor(place), part = place - corner;
    return glm::mix(
        glm::mix(at(corner.x, corner.y), at(corner.x + 1.0, corner.y), part.x),
        glm::mix(at(corner.x, corner.y + 1.0), at(corner.x + 1.0, corner.y + 1.0), part.x), part.y);
}

}  // namespace

glm::dvec4 textureAt(const Scene& scene, const TextureSlot& slot, const Vertex& a, const Vertex& b,
                     const Vertex& c, double weightB, double weightC) {
    if (!slot.present()) return glm::dvec4(1.0);
    const bool second = slot.texCoord == 1;
    const glm::dvec2 ua(second ? a.texCoord1 : a.texCoord0), ub(second ? b.texCoord1 : b.texCoord0),
        uc(second ? c.texCoord1 : c.texCoord0);
    const glm::dvec2 uv = ua * (1.0 - weightB - weightC) + ub * weightB + uc * weightC;
    // KHR_texture_transform: scaled, turned, moved; v points down, so a counter-clockwise turn of
    // the picture has this sign.
    const glm::dvec2 scaled = uv * glm::dvec2(slot.scale);
    const double cosine = std::cos(slot.rotation), sine = std::sin(slot.rotation);
    const glm::dvec2 turned(cosine * scaled.x + sine * scaled.y,
                            cosine * scaled.y - sine * scaled.x);
    return sampled(scene, scene.textures[slot.texture], turned + glm::dvec2(slot.offset));
}

}  // namespace clerestory::reference
