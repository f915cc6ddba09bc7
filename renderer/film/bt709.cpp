#include "film/bt709.h"

namespace clerestory {
namespace {

// BT.709-6, items 3.2 and 3.3.
constexpr float kRed = 0.2126f, kGreen = 0.7152f, kBlue = 0.0722f;

float luma(const float* rgb) {
    return kRed * rgb[0] + kGreen * rgb[1] + kBlue * rgb[2];  // 0 to 255
}

std::uint8_t code(float value) {
    return static_cast<std::uint8_t>(value + 0.5f);
}

}  // namespace

void toBt709(const Image& image, const std::array<ImagePlane, 3>& planes) {
    requireImage(image, "BT.709", PixelType::srgb8, {4}, 1u << 14);
    const std::size_t stride = std::size_t(4) * image.width;
    for (std::uint32_t y = 0; y < image.height; ++y) {
        const std::uint8_t* row = image.bytes() + y * stride;
        std::uint8_t* to = planes[0].bytes + std::ptrdiff_t(y) * planes[0].stride;
        for (std::uint32_t x = 0; x < image.width; ++x, row += 4) {
            const float rgb[3] = {float(row[0]), float(row[1]), float(row[2])};
            to[x] = code(16.0f + luma(rgb) * (219.0f / 255.0f));
        }
    }
    for (std::uint32_t y = 0; y + 1 < image.height; y += 2) {
        const std::uint8_t* row = image.bytes() + y * stride;
        std::uint8_t* blue = planes[1].bytes + std::ptrdiff_t(y / 2) * planes[1].stride;
        std::uint8_t* red = planes[2].bytes + std::ptrdiff_t(y / 2) * planes[2].stride;
        for (std::uint32_t x = 0; x + 1 < image.width; x += 2) {
            const std::size_t left = std::size_t(4) * (x > 0 ? x - 1 : 0), at = std::size_t(4) * x;
            float rgb[3];
            for (std::size_t c = 0; c < 3; ++c) {
                const auto column = [&](std::size_t i) { return row[i + c] + row[stride + i + c]; };
                rgb[c] = float(column(left) + 2 * column(at) + column(at + 4)) / 8.0f;
            }
            const float y709 = luma(rgb);
            constexpr float kScale = 224.0f / 255.0f;
            blue[x / 2] = code(128.0f + (rgb[2] - y709) * (kScale / (2.0f * (1.0f - kBlue))));
            red[x / 2] = code(128.0f + (rgb[0] - y709) * (kScale / (2.0f * (1.0f - kRed))));
        }
    }
}

}  // namespace clerestory
