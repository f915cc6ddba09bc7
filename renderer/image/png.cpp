// PNG with libpng's simplified interface, which reports errors without longjmp.
#include "image/encode.h"

#include <png.h>

#include <stdexcept>

namespace clerestory {
namespace {

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
