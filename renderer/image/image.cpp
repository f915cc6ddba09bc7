#include "image/image.h"

#include <stdexcept>

namespace clerestory {

Image makeImage(std::uint32_t width, std::uint32_t height, std::uint32_t channels, PixelType type) {
    if (channels != 1 && channels != 3 && channels != 4) {
        throw std::runtime_error("an image has 1, 3 or 4 channels, not " +
                                 std::to_string(channels));
    }
    const std::size_t sample = type == PixelType::float32 ? sizeof(float) : 1;
    Image image{.width = width, .height = height, .channels = channels, .type = type};
    image.data.resize(std::size_t(width) * height * channels * sample);
    return image;
}

}  // namespace clerestory
