#include "image/image.h"

#include <webp/encode.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace clerestory {
namespace {

bool hasAlpha(const Image& image) {
    for (std::size_t i = 3; i < image.data.size(); i += 4) {
        if (image.bytes()[i] != 255) return true;
    }
    return false;
}

}  // namespace

Bytes encodeWebp(const Image& image, int quality) {
    const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    if (image.type != PixelType::srgb8 || (image.channels != 3 && image.channels != 4) ||
        width < 1 || height < 1 || width > WEBP_MAX_DIMENSION || height > WEBP_MAX_DIMENSION) {
        throw std::invalid_argument("WebP needs srgb8 with 3 or 4 channels, at most 16383 pixels");
    }
    WebPConfig config;
    WebPPicture picture;
    if (!WebPConfigPreset(&config, WEBP_PRESET_DEFAULT,
                          static_cast<float>(std::clamp(quality, 1, 100))) ||
        !WebPPictureInit(&picture)) {
        throw std::runtime_error("WebP: initialisation failed");
    }
    const std::unique_ptr<WebPPicture, void (*)(WebPPicture*)> owned(&picture, WebPPictureFree);
    picture.width = width;
    picture.height = height;
    const int stride = width * static_cast<int>(image.channels);
    const auto import = image.channels != 4 ? WebPPictureImportRGB
                        : hasAlpha(image)   ? WebPPictureImportRGBA
                                            : WebPPictureImportRGBX;
    const bool imported = import(&picture, image.bytes(), stride) != 0;
    WebPMemoryWriter writer;
    WebPMemoryWriterInit(&writer);
    const std::unique_ptr<WebPMemoryWriter, void (*)(WebPMemoryWriter*)> written(
        &writer, WebPMemoryWriterClear);
    picture.writer = WebPMemoryWrite;
    picture.custom_ptr = &writer;
    if (!imported || !WebPEncode(&config, &picture)) {
        throw std::runtime_error("WebP: encoding failed");
    }
    return {reinterpret_cast<const char*>(writer.mem), writer.size};
}

}  // namespace clerestory
