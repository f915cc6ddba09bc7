#include "image/image.h"

#include <algorithm>
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

void requireImage(const Image& image, const std::string& format, PixelType type,
                  std::initializer_list<std::uint32_t> channels, std::uint32_t maxEdge) {
    const auto fail = [&](const std::string& why) {
        throw std::runtime_error(format + ": cannot encode an image " + why);
    };
    if (image.width == 0 || image.height == 0) fail("without pixels");
    if (image.width > maxEdge || image.height > maxEdge) {
        fail("with an edge above " + std::to_string(maxEdge));
    }
    if (image.type != type) {
        fail(type == PixelType::srgb8 ? "of type float; 8 bits are required"
                                      : "of 8 bits; float is required");
    }
    if (std::find(channels.begin(), channels.end(), image.channels) == channels.end()) {
        fail("with " + std::to_string(image.channels) + " channels");
    }
    const std::size_t sample = type == PixelType::float32 ? sizeof(float) : 1;
    if (image.data.size() != std::size_t(image.width) * image.height * image.channels * sample) {
        fail("whose data size is not width * height * channels");
    }
}

void requireDecodable(const std::string& format, std::uint64_t width, std::uint64_t height) {
    if (width == 0 || height == 0 || width > kMaxDecodedPixels / height) {
        throw std::runtime_error(format + ": cannot decode " + std::to_string(width) + " x " +
                                 std::to_string(height) + " pixels: too large or empty");
    }
}

}  // namespace clerestory
