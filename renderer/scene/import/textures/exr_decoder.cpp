// OpenEXR images, decoded by tinyexr after checks of the header. Runs in the import's child
// process.
#include "scene/import/base/types.h"
#include "scene/import/textures/image_decoder.h"

#include <tinyexr.h>

#include <cstdlib>
#include <cstring>
#include <memory>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

// Largest number of channels: tinyexr decodes all of them.
constexpr int kMaxChannels = 16;

struct ExrHeader : EXRHeader {
    ExrHeader() { InitEXRHeader(this); }
    ~ExrHeader() { FreeEXRHeader(this); }
    ExrHeader(const ExrHeader&) = delete;
    ExrHeader& operator=(const ExrHeader&) = delete;
};

// A message that tinyexr allocates and frees.
struct Message {
    const char* text = nullptr;
    ~Message() { FreeEXRErrorMessage(text); }
};

[[noreturn]] void broken() {
    throw ImportError(Reason::malformed, "the .exr image is damaged");
}

void checkHeader(std::span<const unsigned char> file, std::uint64_t maxPixels) {
    EXRVersion version{};
    if (ParseEXRVersionFromMemory(&version, file.data(), file.size()) != TINYEXR_SUCCESS) broken();
    if (version.multipart || version.non_image) {
        throw ImportError(Reason::unsupported, "multi-part .exr images are not supported");
    }
    ExrHeader header;
    Message message;
    if (ParseEXRHeaderFromMemory(&header, &version, file.data(), file.size(), &message.text) !=
        TINYEXR_SUCCESS) {
        broken();
    }
    const EXRBox2i& box = header.data_window;
    const std::int64_t width = std::int64_t{box.max_x} - box.min_x + 1;
    const std::int64_t height = std::int64_t{box.max_y} - box.min_y + 1;
    if (width <= 0 || height <= 0 || header.num_channels <= 0) broken();
    if (header.num_channels > kMaxChannels || width > INT32_MAX || height > INT32_MAX ||
        static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) > maxPixels) {
        throw ImportError(Reason::limit, "the .exr image of " + std::to_string(width) + " x " +
                                             std::to_string(height) + " pixels and " +
                                             std::to_string(header.num_channels) +
                                             " channels exceeds the limit");
    }
}

}  // namespace

bool isExr(std::span<const unsigned char> file) {
    constexpr unsigned char kMagic[]{0x76, 0x2F, 0x31, 0x01};
    return file.size() >= sizeof kMagic && std::memcmp(file.data(), kMagic, sizeof kMagic) == 0;
}

RadianceImage decodedExr(std::span<const unsigned char> file, std::uint64_t maxPixels) {
    checkHeader(file, maxPixels);
    float* rgba = nullptr;
    int width = 0, height = 0;
    Message message;
    if (LoadEXRFromMemory(&rgba, &width, &height, file.data(), file.size(), &message.text) !=
        TINYEXR_SUCCESS) {
        throw ImportError(Reason::malformed,
                          "the .exr image could not be read: it needs channels R, G and B, "
                          "uncompressed or compressed with RLE, ZIP or PIZ");
    }
    const std::unique_ptr<float, void (*)(void*)> owned(rgba, std::free);
    if (!rgba || width <= 0 || height <= 0) broken();
    RadianceImage image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    image.texels.reserve(std::size_t{image.width} * image.height);
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i) {
        image.texels.emplace_back(rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]);
    }
    return image;
}

}  // namespace clerestory
