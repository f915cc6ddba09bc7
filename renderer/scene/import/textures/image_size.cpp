#include "scene/import/textures/image_size.h"

#include "scene/import/base/types.h"

#include <limits>
#include <string>

namespace clerestory {
namespace {

// Throws ImportError if the allowance is too small.
void spend(std::atomic<std::uint64_t>& pixelsLeft, std::uint64_t pixels) {
    std::uint64_t left = pixelsLeft.load();
    do {
        if (left < pixels) {
            throw ImportError(ImportError::Reason::limit,
                              "the scene's images have too many pixels in total");
        }
    } while (!pixelsLeft.compare_exchange_weak(left, left - pixels));
}

}  // namespace

void checkImageSize(std::int64_t width, std::int64_t height, std::uint64_t maxPixels) {
    constexpr std::int64_t kMaxSide = std::numeric_limits<std::int32_t>::max();
    if (width <= 0 || height <= 0) {
        throw ImportError(ImportError::Reason::malformed, "the image has no pixels");
    }
    if (width > kMaxSide || height > kMaxSide ||
        static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) > maxPixels) {
        throw ImportError(ImportError::Reason::limit, "the image of " + std::to_string(width) +
                                                          " x " + std::to_string(height) +
                                                          " pixels exceeds the limit");
    }
}

TextureImage allottedImage(std::int64_t width, std::int64_t height, std::uint64_t maxPixels,
                           std::atomic<std::uint64_t>& pixelsLeft) {
    checkImageSize(width, height, maxPixels);
    spend(pixelsLeft, static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
    TextureImage image;
    image.width = static_cast<std::uint32_t>(width);
    image.height = static_cast<std::uint32_t>(height);
    image.levels = 1;
    image.texels.resize(std::size_t{4} * image.width * image.height);
    return image;
}

}  // namespace clerestory
