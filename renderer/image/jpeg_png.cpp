// JPEG with TurboJPEG, which reports errors where libjpeg would call exit(); PNG with libpng's
// simplified interface, which reports errors without longjmp.
#include "image/image.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace clerestory {
namespace {

struct TurboClose {
    void operator()(void* handle) const { tjDestroy(handle); }
};
using Turbo = std::unique_ptr<void, TurboClose>;

struct TurboFree {
    void operator()(unsigned char* memory) const { tjFree(memory); }
};

[[noreturn]] void fail(const char* operation, tjhandle handle) {
    throw std::runtime_error(std::string("JPEG: ") + operation + ": " + tjGetErrorStr2(handle));
}

struct PngImage : png_image {
    PngImage() : png_image{} { version = PNG_IMAGE_VERSION; }
    ~PngImage() { png_image_free(this); }
    PngImage(const PngImage&) = delete;
    PngImage& operator=(const PngImage&) = delete;
};

[[noreturn]] void fail(const char* operation, const PngImage& png) {
    throw std::runtime_error(std::string("PNG: ") + operation + ": " + png.message);
}

}  // namespace

Bytes encodeJpeg(const Image& image, int quality, bool subsample420) {
    requireImage(image, "JPEG", PixelType::srgb8, {3, 4}, 65500);
    const Turbo turbo(tjInitCompress());  // creating one per call costs nothing measurable
    if (!turbo) fail("initialisation", nullptr);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    const int failed = tjCompress2(
        turbo.get(), image.bytes(), static_cast<int>(image.width), 0,
        static_cast<int>(image.height), image.channels == 4 ? TJPF_RGBX : TJPF_RGB, &memory, &size,
        subsample420 ? TJSAMP_420 : TJSAMP_444, std::clamp(quality, 1, 100), 0);
    const std::unique_ptr<unsigned char, TurboFree> owned(memory);
    if (failed) fail("encoding", turbo.get());
    return Bytes(reinterpret_cast<const char*>(memory), size);
}

Image decodeJpeg(std::string_view bytes) {
    const Turbo turbo(tjInitDecompress());
    if (!turbo) fail("initialisation", nullptr);
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    int width = 0, height = 0, subsampling = 0, colorSpace = 0;
    if (tjDecompressHeader3(turbo.get(), data, bytes.size(), &width, &height, &subsampling,
                            &colorSpace)) {
        fail("reading the header", turbo.get());
    }
    requireDecodable("JPEG", static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
    Image image = makeImage(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                            3, PixelType::srgb8);
    if (tjDecompress2(turbo.get(), data, bytes.size(), image.bytes(), width, 0, height, TJPF_RGB,
                      TJFLAG_ACCURATEDCT)) {
        fail("decoding", turbo.get());
    }
    return image;
}

Bytes encodePng(const Image& image) {
    requireImage(image, "PNG", PixelType::srgb8, {1, 3, 4}, 32768);
    PngImage png;
    png.width = image.width;
    png.height = image.height;
    png.format = image.channels == 1   ? PNG_FORMAT_GRAY
                 : image.channels == 3 ? PNG_FORMAT_RGB
                                       : PNG_FORMAT_RGBA;
    png.flags = PNG_IMAGE_FLAG_FAST;  // halves the time for a few per cent more size
    // One pass into a buffer of the maximum size, then truncated.
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    Bytes bytes(size, '\0');
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.bytes(), 0, nullptr)) {
        fail("encoding", png);
    }
    bytes.resize(size);
    return bytes;
}

Image decodePng(std::string_view bytes) {
    PngImage png;
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) {
        fail("reading the header", png);
    }
    requireDecodable("PNG", png.width, png.height);
    png.format = PNG_FORMAT_RGBA;
    Image image = makeImage(png.width, png.height, 4, PixelType::srgb8);
    if (!png_image_finish_read(&png, nullptr, image.bytes(), 0, nullptr)) fail("decoding", png);
    return image;
}

}  // namespace clerestory
