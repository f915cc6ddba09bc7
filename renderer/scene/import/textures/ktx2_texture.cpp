#include "scene/import/textures/ktx2_texture.h"

#include "scene/import/base/types.h"
#include "scene/import/textures/basis_bits.h"
#include "scene/import/textures/basis_lz.h"
#include "scene/import/textures/image_size.h"
#include "scene/import/textures/uastc_block.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace clerestory {
namespace {

using Ktx2Span = std::span<const unsigned char>;

[[noreturn]] void unsupportedKtx2(const std::string& what) {
    throw ImportError(ImportError::Reason::unsupported,
                      "KTX2 textures with " + what + " are not supported");
}

// The offsets below are those of the KTX File Format Specification 2.0.
enum class Supercompression : std::uint64_t { none, basisLz, zstandard };

// The bytes of all blocks; `storage` holds them if they were compressed.
Ktx2Span blocksOf(Ktx2Span level, Supercompression scheme, std::size_t size,
                  std::vector<unsigned char>& storage) {
    if (scheme == Supercompression::zstandard) {
        storage.resize(size);
        if (ZSTD_decompress(storage.data(), size, level.data(), level.size()) != size) {
            damagedBasis("its Zstandard data is not of the size of the image");
        }
        return storage;
    }
    if (level.size() < size) damagedBasis("its level has too few bytes");
    return level.first(size);
}

void decodeBlocks(Ktx2Span blocks, TextureImage& image) {
    const std::uint32_t across = (image.width + 3) / 4;
    for (std::size_t b = 0; b < blocks.size() / kUastcBlockBytes; ++b) {
        const auto texels =
            decodedUastc(blocks.subspan(b * kUastcBlockBytes).first<kUastcBlockBytes>());
        if (!texels) damagedBasis("a UASTC block has an unknown mode or pattern");
        const std::size_t left = 4 * (b % across), top = 4 * (b / across);
        const std::size_t columns = std::min<std::size_t>(4, image.width - left),
                          rows = std::min<std::size_t>(4, image.height - top);
        for (std::size_t y = 0; y < rows; ++y) {
            std::memcpy(&image.texels[4 * ((top + y) * image.width + left)], &(*texels)[4 * y],
                        4 * columns);
        }
    }
}

}  // namespace

bool isKtx2(Ktx2Span file) {
    constexpr unsigned char kMagic[]{0xAB, 'K',  'T',  'X',  ' ',  '2',
                                     '0',  0xBB, '\r', '\n', 0x1A, '\n'};
    return file.size() >= sizeof kMagic && std::memcmp(file.data(), kMagic, sizeof kMagic) == 0;
}

TextureImage decodedKtx2(Ktx2Span file, std::uint64_t maxPixels,
                         std::atomic<std::uint64_t>& pixelsLeft) {
    const std::uint64_t width = numberIn(file, 20, 4), height = numberIn(file, 24, 4);
    if (numberIn(file, 28, 4) > 1 || numberIn(file, 32, 4) > 1 || numberIn(file, 36, 4) != 1) {
        unsupportedKtx2("layers, faces or depth");
    }
    const std::uint64_t levels = std::max<std::uint64_t>(1, numberIn(file, 40, 4));
    const auto scheme = static_cast<Supercompression>(numberIn(file, 44, 4));
    if (levels > 32) damagedBasis("it has more than 32 levels");
    // The data format descriptor begins with its size; the colour model is in its third word.
    constexpr std::uint64_t kEtc1s = 163, kUastc = 166;
    const std::uint64_t model = numberIn(partOf(file, numberIn(file, 48, 4), 16), 12, 1);
    const bool uastc = model == kUastc && scheme != Supercompression::basisLz &&
                       scheme <= Supercompression::zstandard;
    const bool etc1s = model == kEtc1s && scheme == Supercompression::basisLz;
    if (numberIn(file, 12, 4) != 0 || (!uastc && !etc1s)) {
        unsupportedKtx2("other formats than UASTC, with or without Zstandard, and ETC1S");
    }
    const Ktx2Span level = partOf(file, numberIn(file, 80, 8), numberIn(file, 88, 8));
    TextureImage image = allottedImage(static_cast<std::int64_t>(width),
                                       static_cast<std::int64_t>(height), maxPixels, pixelsLeft);
    if (etc1s) {
        decodeBasisLz(partOf(file, numberIn(file, 64, 8), numberIn(file, 72, 8)), level,
                      static_cast<std::uint32_t>(levels), image);
        return image;
    }
    std::vector<unsigned char> storage;
    const std::size_t size = kUastcBlockBytes * ((width + 3) / 4) * ((height + 3) / 4);
    decodeBlocks(blocksOf(level, scheme, size, storage), image);
    return image;
}

}  // namespace clerestory
