// Box-filtered levels through 16-bit linear tables.
#include "scene/texture_images.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace clerestory {
namespace {

// 16 bits of linear light distinguish all 8-bit sRGB codes (the smallest step is 19).
struct SrgbTables {
    std::array<std::uint16_t, 256> linear{};
    std::array<std::uint8_t, 65536> srgb{};

    SrgbTables() {
        for (int i = 0; i < 256; ++i) {
            const double c = i / 255.0;
            const double l = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
            linear[i] = static_cast<std::uint16_t>(std::lround(l * 65535.0));
        }
        // The code with the closest linear value: thresholds are halfway between neighbours.
        int code = 0;
        for (int i = 0; i < 65536; ++i) {
            while (code < 255 && 2 * i > linear[code] + linear[code + 1]) ++code;
            srgb[i] = static_cast<std::uint8_t>(code);
        }
    }
};

const SrgbTables& tables() {
    static const SrgbTables instance;
    return instance;
}

void halve(const std::uint8_t* from, std::uint32_t width, std::uint32_t height, std::uint8_t* to,
           bool srgb) {
    const SrgbTables& t = tables();
    const std::uint32_t outWidth = std::max(1u, width / 2), outHeight = std::max(1u, height / 2);
    for (std::uint32_t y = 0; y < outHeight; ++y) {
        const std::uint8_t* upper = from + 4ull * width * std::min(2 * y, height - 1);
        const std::uint8_t* lower = from + 4ull * width * std::min(2 * y + 1, height - 1);
        for (std::uint32_t x = 0; x < outWidth; ++x, to += 4) {
            const std::uint32_t left = 4 * std::min(2 * x, width - 1),
                                right = 4 * std::min(2 * x + 1, width - 1);
            for (int c = 0; c < 4; ++c) {
                const std::uint8_t a = upper[left + c], b = upper[right + c], d = lower[left + c],
                                   e = lower[right + c];
                if (srgb && c < 3) {
                    to[c] =
                        t.srgb[(t.linear[a] + t.linear[b] + t.linear[d] + t.linear[e] + 2u) / 4u];
                } else {
                    to[c] = static_cast<std::uint8_t>((a + b + d + e + 2) / 4);
                }
            }
        }
    }
}

}  // namespace

namespace {

float leastGreenOf(const TextureImage& image) {
    std::array<std::uint64_t, 256> texelsWith{};
    const std::uint64_t count = std::uint64_t{image.width} * image.height;
    for (std::uint64_t i = 0; i < count; ++i) ++texelsWith[image.texels[4 * i + 1]];
    const std::uint64_t tenth = std::max<std::uint64_t>(1, count / 10);
    std::uint64_t taken = 0, sum = 0;
    for (std::uint64_t code = 0; code < texelsWith.size() && taken < tenth; ++code) {
        const std::uint64_t more = std::min(texelsWith[code], tenth - taken);
        sum += more * code;
        taken += more;
    }
    return static_cast<float>(sum) / (255.0f * static_cast<float>(tenth));
}

}  // namespace

void buildLevels(TextureImage& image) {
    image.hasAlpha = false;
    image.leastGreen = image.colorSpace == ColorSpace::linear ? leastGreenOf(image) : 1.0f;
    for (std::size_t i = 3; i < 4ull * image.width * image.height; i += 4) {
        if (image.texels[i] != 255) {
            image.hasAlpha = true;
            break;
        }
    }
    image.levels = static_cast<std::uint32_t>(std::bit_width(std::max(image.width, image.height)));
    std::uint64_t total = 0;
    for (std::uint32_t l = 0; l < image.levels; ++l) {
        total += 4ull * std::max(1u, image.width >> l) * std::max(1u, image.height >> l);
    }
    image.texels.resize(total);
    std::uint64_t at = 0;
    for (std::uint32_t l = 0; l + 1 < image.levels; ++l) {
        const std::uint32_t width = std::max(1u, image.width >> l),
                            height = std::max(1u, image.height >> l);
        const std::uint64_t next = at + 4ull * width * height;
        halve(image.texels.data() + at, width, height, image.texels.data() + next,
              image.colorSpace == ColorSpace::srgb);
        at = next;
    }
    for (int c = 0; c < 4; ++c) {
        const std::uint8_t code = image.texels[at + static_cast<std::uint64_t>(c)];
        image.mean[c] = image.colorSpace == ColorSpace::srgb && c < 3
                            ? static_cast<float>(tables().linear[code]) / 65535.0f
                            : static_cast<float>(code) / 255.0f;
    }
}

}  // namespace clerestory
