#include "scene/import/textures/webp_decoder.h"

#include "scene/import/base/types.h"
#include "scene/import/textures/image_size.h"

#include <webp/decode.h>

#include <cstring>

namespace clerestory {

bool isWebp(std::span<const unsigned char> file) {
    return file.size() >= 12 && std::memcmp(file.data(), "RIFF", 4) == 0 &&
           std::memcmp(file.data() + 8, "WEBP", 4) == 0;
}

TextureImage decodedWebp(std::span<const unsigned char> file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(file.data(), file.size(), &features) != VP8_STATUS_OK) {
        throw ImportError(ImportError::Reason::malformed, "the WebP image is damaged");
    }
    if (features.has_animation) {
        throw ImportError(ImportError::Reason::unsupported,
                          "animated WebP images are not supported");
    }
    TextureImage image = allottedImage(features.width, features.height, maxPixels, pixelsLeft);
    if (!WebPDecodeRGBAInto(file.data(), file.size(), image.texels.data(), image.texels.size(),
                            features.width * 4)) {
        throw ImportError(ImportError::Reason::malformed, "the WebP image is damaged");
    }
    return image;
}

}  // namespace clerestory
