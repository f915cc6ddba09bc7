// JPEG with TurboJPEG, which reports errors where libjpeg would call exit().
#include "image/encode.h"

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

}  // namespace clerestory
