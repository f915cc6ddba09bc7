#include "scene/import/textures/image_decoder.h"

#include "scene/import/base/types.h"
#include "scene/import/textures/avif_decoder.h"
#include "scene/import/textures/image_size.h"
#include "scene/import/textures/ktx2_texture.h"
#include "scene/import/textures/webp_decoder.h"
#include "scene/srgb.h"

#include <tinyexr.h>
#include <turbojpeg.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_JPEG  // for variants that TurboJPEG does not support
#define STBI_ONLY_PNG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STBI_ONLY_PSD
#define STBI_ONLY_HDR
#include <stb/stb_image.h>

#include <array>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Bytes = std::span<const unsigned char>;

struct StbDeleter {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

bool startsWith(Bytes file, std::string_view magic) {
    return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
}

void rejectUnsupportedFormats(Bytes file) {
    if (file.size() > INT_MAX) {
        throw ImportError(Reason::limit, "the image file is too large");
    }
    if (startsWith(file, "\xABKTX 11")) {
        throw ImportError(Reason::unsupported,
                          "images in KTX files of version 1 are not supported");
    }
}

// Nothing if TurboJPEG does not support the variant, for example CMYK.
std::optional<TextureImage> decodedByTurboJpeg(Bytes file, std::uint64_t maxPixels,
                                               std::atomic<std::uint64_t>& pixelsLeft) {
    const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
    int width = 0;
    int height = 0;
    int subsampling = 0;
    int colorSpace = 0;
    if (!decoder || tjDecompressHeader3(decoder.get(), file.data(), file.size(), &width, &height,
                                        &subsampling, &colorSpace) != 0) {
        return std::nullopt;
    }
    checkImageSize(width, height, maxPixels);
    if (colorSpace == TJCS_CMYK || colorSpace == TJCS_YCCK) {
        return std::nullopt;
    }
    TextureImage image = allottedImage(width, height, maxPixels, pixelsLeft);
    const int failed = tjDecompress2(decoder.get(), file.data(), file.size(), image.texels.data(),
                                     width, 0, height, TJPF_RGBA, 0);
    // After a warning (a truncated file) the image is usable.
    if (failed != 0 && tjGetErrorCode(decoder.get()) == TJERR_FATAL) {
        return std::nullopt;
    }
    return image;
}

TextureImage decodedByStb(Bytes file, std::uint64_t maxPixels,
                          std::atomic<std::uint64_t>& pixelsLeft) {
    const int length = static_cast<int>(file.size());
    int width = 0;
    int height = 0;
    int channels = 0;
    if (!stbi_info_from_memory(file.data(), length, &width, &height, &channels)) {
        throw ImportError(Reason::malformed, "the image is damaged or of an unknown format");
    }
    TextureImage image = allottedImage(width, height, maxPixels, pixelsLeft);
    const std::unique_ptr<stbi_uc, StbDeleter> pixels(
        stbi_load_from_memory(file.data(), length, &width, &height, &channels, 4));
    if (!pixels) {
        throw ImportError(Reason::malformed, "the image is damaged");
    }
    std::memcpy(image.texels.data(), pixels.get(), image.texels.size());
    return image;
}

// OpenEXR images, decoded by tinyexr after checks of the header.

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

TextureImage decodedImage(Bytes file, std::uint64_t maxPixels,
                          std::atomic<std::uint64_t>& pixelsLeft) {
    rejectUnsupportedFormats(file);
    if (isWebp(file)) return decodedWebp(file, maxPixels, pixelsLeft);
    if (isKtx2(file)) return decodedKtx2(file, maxPixels, pixelsLeft);
    if (isAvif(file)) return decodedAvif(file, maxPixels, pixelsLeft);
    if (startsWith(file, "\xFF\xD8")) {
        if (auto image = decodedByTurboJpeg(file, maxPixels, pixelsLeft)) {
            return std::move(*image);
        }
    }
    return decodedByStb(file, maxPixels, pixelsLeft);
}

namespace {

// stb_image reads zeros after the end of a file; this records it. Its buffer is filled in pieces of
// kBuffer bytes, of which the last may be short; whatever is read past the buffer is needed.
struct HdrSource {
    static constexpr int kBuffer = 128;
    Bytes file;
    std::size_t at = 0;
    bool isTruncated = false;

    static int read(void* user, char* to, int size) {
        HdrSource& source = *static_cast<HdrSource*>(user);
        const std::size_t got =
            std::min(static_cast<std::size_t>(size), source.file.size() - source.at);
        std::memcpy(to, source.file.data() + source.at, got);
        source.at += got;
        if (got == 0 || (static_cast<int>(got) < size && size < kBuffer)) source.isTruncated = true;
        return static_cast<int>(got);
    }
    static void skip(void* user, int count) {
        HdrSource& source = *static_cast<HdrSource*>(user);
        source.at +=
            std::min(static_cast<std::size_t>(std::max(count, 0)), source.file.size() - source.at);
    }
    static int eof(void* user) {
        const HdrSource& source = *static_cast<const HdrSource*>(user);
        return source.at == source.file.size();
    }
};

}  // namespace

RadianceImage decodedRadiance(Bytes file, std::uint64_t maxPixels) {
    RadianceImage radiance;
    rejectUnsupportedFormats(file);
    if (isExr(file)) return decodedExr(file, maxPixels);
    const int length = static_cast<int>(file.size());
    if (!stbi_is_hdr_from_memory(file.data(), length)) {
        std::atomic<std::uint64_t> allowance{maxPixels};
        const TextureImage image = decodedImage(file, maxPixels, allowance);
        std::array<float, 256> linear{};
        for (int code = 0; code < 256; ++code) {
            linear[static_cast<std::size_t>(code)] =
                linearFromSrgb(static_cast<float>(code) / 255.0f);
        }
        radiance = {image.width, image.height, {}};
        radiance.texels.reserve(image.texels.size() / 4);
        for (std::size_t i = 0; i < image.texels.size(); i += 4) {
            radiance.texels.emplace_back(linear[image.texels[i]], linear[image.texels[i + 1]],
                                         linear[image.texels[i + 2]]);
        }
        return radiance;
    }
    int width = 0;
    int height = 0;
    int channels = 0;
    if (!stbi_info_from_memory(file.data(), length, &width, &height, &channels)) {
        throw ImportError(Reason::malformed, "the .hdr image is damaged");
    }
    checkImageSize(width, height, maxPixels);
    HdrSource source{file};
    const stbi_io_callbacks calls{HdrSource::read, HdrSource::skip, HdrSource::eof};
    const std::unique_ptr<float, StbDeleter> pixels(
        stbi_loadf_from_callbacks(&calls, &source, &width, &height, &channels, 3));
    if (!pixels || source.isTruncated) {
        throw ImportError(Reason::malformed, "the .hdr image is damaged");
    }
    radiance.width = static_cast<std::uint32_t>(width);
    radiance.height = static_cast<std::uint32_t>(height);
    radiance.texels.resize(std::size_t{radiance.width} * radiance.height);
    std::memcpy(radiance.texels.data(), pixels.get(), radiance.texels.size() * sizeof(glm::vec3));
    return radiance;
}

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
