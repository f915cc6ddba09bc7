#include "scene/import/textures/web_images.h"

#include "scene/import/base/types.h"

#include <avif/avif.h>
#include <webp/decode.h>

#include <cstring>
#include <memory>
#include <string>
#include <string_view>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Bytes = std::span<const unsigned char>;

bool has(Bytes file, std::size_t at, std::string_view mark) {
    return file.size() >= at + mark.size() &&
           std::memcmp(file.data() + at, mark.data(), mark.size()) == 0;
}

[[noreturn]] void damaged(const char* kind) {
    throw ImportError(Reason::malformed, std::string("the ") + kind + " image is damaged");
}

TextureImage sized(std::uint32_t width, std::uint32_t height) {
    TextureImage image;
    image.width = width;
    image.height = height;
    image.levels = 1;
    image.texels.resize(std::size_t{4} * width * height);
    return image;
}

}  // namespace

bool isWebp(Bytes file) {
    return has(file, 0, "RIFF") && has(file, 8, "WEBP");
}

// A box "ftyp" of the brand "avif", or of "mif1" as older writers have it; "avis": a sequence.
bool isAvif(Bytes file) {
    return has(file, 4, "ftypavif") || has(file, 4, "ftypavis") || has(file, 4, "ftypmif1");
}

TextureImage decodedWebp(Bytes file, const AdmitSize& admit) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(file.data(), file.size(), &features) != VP8_STATUS_OK ||
        features.width <= 0 || features.height <= 0) {
        damaged("WebP");
    }
    if (features.has_animation) {
        throw ImportError(Reason::unsupported, "animated WebP images are not supported");
    }
    const auto width = static_cast<std::uint32_t>(features.width);
    const auto height = static_cast<std::uint32_t>(features.height);
    admit(width, height);
    TextureImage image = sized(width, height);
    if (!WebPDecodeRGBAInto(file.data(), file.size(), image.texels.data(), image.texels.size(),
                            4 * features.width)) {
        damaged("WebP");
    }
    return image;
}

TextureImage decodedAvif(Bytes file, const AdmitSize& admit) {
    const std::unique_ptr<avifDecoder, void (*)(avifDecoder*)> decoder(avifDecoderCreate(),
                                                                       avifDecoderDestroy);
    if (!decoder) throw std::bad_alloc();
    decoder->maxThreads = 1;
    decoder->ignoreExif = decoder->ignoreXMP = AVIF_TRUE;
    if (avifDecoderSetIOMemory(decoder.get(), file.data(), file.size()) != AVIF_RESULT_OK ||
        avifDecoderParse(decoder.get()) != AVIF_RESULT_OK) {
        damaged("AVIF");
    }
    if (decoder->imageCount > 1) {
        throw ImportError(Reason::unsupported, "animated AVIF images are not supported");
    }
    const std::uint32_t width = decoder->image->width, height = decoder->image->height;
    if (width == 0 || height == 0) damaged("AVIF");
    admit(width, height);
    if (avifDecoderNextImage(decoder.get()) != AVIF_RESULT_OK || decoder->image->width != width ||
        decoder->image->height != height) {
        damaged("AVIF");
    }
    TextureImage image = sized(width, height);
    avifRGBImage pixels;
    avifRGBImageSetDefaults(&pixels, decoder->image);
    pixels.format = AVIF_RGB_FORMAT_RGBA;
    pixels.depth = 8;
    pixels.pixels = image.texels.data();
    pixels.rowBytes = 4 * width;
    if (avifImageYUVToRGB(decoder->image, &pixels) != AVIF_RESULT_OK) damaged("AVIF");
    return image;
}

}  // namespace clerestory
