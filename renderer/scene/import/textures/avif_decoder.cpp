#include "scene/import/textures/avif_decoder.h"

#include "scene/import/base/types.h"
#include "scene/import/textures/image_size.h"

#include <avif/avif.h>

#include <algorithm>
#include <memory>
#include <new>
#include <string>

namespace clerestory {
namespace {

[[noreturn]] void damagedAvif(const std::string& orWhat = "") {
    throw ImportError(ImportError::Reason::malformed,
                      "the AVIF image is damaged" + (orWhat.empty() ? "" : " " + orWhat));
}

void checkResult(avifResult result) {
    if (result == AVIF_RESULT_OUT_OF_MEMORY) throw std::bad_alloc();
    if (result == AVIF_RESULT_NO_CODEC_AVAILABLE) {
        throw ImportError(ImportError::Reason::unsupported,
                          "this machine's libavif has no decoder of AV1");
    }
    if (result != AVIF_RESULT_OK) damagedAvif();
}

void rejectUnsupported(const avifDecoder& decoder) {
    if (decoder.imageCount != 1) {
        throw ImportError(ImportError::Reason::unsupported,
                          "AVIF image sequences are not supported");
    }
    constexpr avifTransformFlags kChanges =
        AVIF_TRANSFORM_CLAP | AVIF_TRANSFORM_IROT | AVIF_TRANSFORM_IMIR;
    if ((decoder.image->transformFlags & kChanges) != 0) {
        throw ImportError(ImportError::Reason::unsupported,
                          "AVIF images that are to be cropped, rotated or mirrored are not "
                          "supported");
    }
}

}  // namespace

bool isAvif(std::span<const unsigned char> file) {
    const avifROData bytes{file.data(), file.size()};
    return avifPeekCompatibleFileType(&bytes) != AVIF_FALSE;
}

TextureImage decodedAvif(std::span<const unsigned char> file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft) {
    const std::unique_ptr<avifDecoder, void (*)(avifDecoder*)> decoder(avifDecoderCreate(),
                                                                       avifDecoderDestroy);
    if (!decoder) throw std::bad_alloc();
    decoder->maxThreads = 1;
    decoder->ignoreExif = decoder->ignoreXMP = AVIF_TRUE;
    // Some encoders leave out the property `pixi`, which only repeats the bit depth.
    decoder->strictFlags =
        AVIF_STRICT_ENABLED & ~static_cast<avifStrictFlags>(AVIF_STRICT_PIXI_REQUIRED);
    checkResult(avifDecoderSetIOMemory(decoder.get(), file.data(), file.size()));
    const avifResult parsed = avifDecoderParse(decoder.get());  // the container; decodes no pixels
    if (parsed == AVIF_RESULT_BMFF_PARSE_FAILED) damagedAvif("or too large");
    checkResult(parsed);
    rejectUnsupported(*decoder);
    const std::uint32_t width = decoder->image->width, height = decoder->image->height;
    TextureImage image = allottedImage(width, height, maxPixels, pixelsLeft);
    // For the AV1 data within, which may declare another size.
    constexpr std::uint64_t kMaxSetting = 16384 * 16384;
    decoder->imageSizeLimit =
        static_cast<std::uint32_t>(std::clamp<std::uint64_t>(maxPixels, 1, kMaxSetting));
    checkResult(avifDecoderNextImage(decoder.get()));
    if (decoder->image->width != width || decoder->image->height != height) damagedAvif();
    avifRGBImage rgb;
    avifRGBImageSetDefaults(&rgb, decoder->image);
    rgb.format = AVIF_RGB_FORMAT_RGBA;
    rgb.depth = 8;
    rgb.pixels = image.texels.data();
    rgb.rowBytes = 4 * width;
    checkResult(avifImageYUVToRGB(decoder->image, &rgb));
    return image;
}

}  // namespace clerestory
