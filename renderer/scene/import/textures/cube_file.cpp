#include "scene/import/textures/cube_file.h"

#include "scene/import/base/types.h"
#include "scene/import/textures/texel_format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Bytes = std::span<const unsigned char>;

constexpr std::string_view kMagic1("\xABKTX 11\xBB\r\n\x1A\n", 12);
constexpr std::string_view kMagic2("\xABKTX 20\xBB\r\n\x1A\n", 12);
constexpr std::string_view kMagicDds("DDS ", 4);
constexpr std::uint32_t kSameEndianness = 0x04030201;

bool opensWith(Bytes file, std::string_view magic) {
    return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
}

[[noreturn]] void malformedCube(const char* what) {
    throw ImportError(Reason::malformed, std::string("the cube map file ") + what);
}

// `count` bytes at `offset`. Throws ImportError if the file is shorter.
Bytes part(Bytes file, std::uint64_t offset, std::uint64_t count) {
    if (offset > file.size() || count > file.size() - offset) malformedCube("is cut short");
    return file.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(count));
}

template <class T>
T numberAt(Bytes file, std::uint64_t offset) {
    T value{};
    std::memcpy(&value, part(file, offset, sizeof value).data(), sizeof value);
    return value;
}

struct Faces {
    TexelFormat format;
    std::uint32_t size = 0;
    std::uint64_t faceBytes = 0;   // without padding between faces
    std::uint64_t faceStride = 0;  // from one face to the next
    std::uint64_t rowAlignment = 1;
    Bytes bytes;
    bool firstRowBelow = false;
};

void requireCube(std::uint32_t width, std::uint32_t height, std::uint32_t depth,
                 std::uint32_t layers, std::uint32_t faces) {
    if (faces != 6) {
        throw ImportError(Reason::unsupported,
                          "the file has no cube map: it has " + std::to_string(faces) + " faces");
    }
    if (layers > 0) throw ImportError(Reason::unsupported, "arrays of cube maps are not supported");
    if (width == 0 || width != height || depth > 1) malformedCube("has faces that are not square");
}

void requirePixels(std::uint32_t size, std::uint64_t maxPixels) {
    constexpr std::uint32_t kLargestEdge = 1u << 16;  // so that the product is a 64-bit number
    if (size > kLargestEdge || 6ull * size * size > maxPixels) {
        throw ImportError(Reason::limit, "the cube map of " + std::to_string(size) +
                                             " texels an edge exceeds the limit");
    }
}

// Key-value data: each pair is preceded by its length. KTXorientation has the direction of rows.
bool startsBelow(Bytes pairs) {
    while (pairs.size() >= 4) {
        const auto length = numberAt<std::uint32_t>(pairs, 0);
        const Bytes pair = part(pairs, 4, length);
        const std::string_view text(reinterpret_cast<const char*>(pair.data()), pair.size());
        constexpr std::string_view kKey("KTXorientation\0", 15);
        if (text.starts_with(kKey)) {
            const std::string_view value = text.substr(kKey.size());
            return value.find("T=u") != std::string_view::npos || value.starts_with("ru");
        }
        const std::uint64_t padded = (4ull + length + 3) / 4 * 4;
        if (padded >= pairs.size()) break;
        pairs = pairs.subspan(static_cast<std::size_t>(padded));
    }
    return false;
}

Faces facesOfKtx1(Bytes file, std::uint64_t maxPixels) {
    std::array<std::uint32_t, 13> header{};
    std::memcpy(header.data(), part(file, 12, sizeof header).data(), sizeof header);
    const auto [endianness, type, typeSize, layout, internal, baseInternal, width, height, depth,
                layers, faces, levels, pairBytes] = header;
    if (endianness != kSameEndianness) {
        throw ImportError(Reason::unsupported, "big-endian KTX files are not supported");
    }
    requireCube(width, height, depth, layers, faces);
    requirePixels(width, maxPixels);
    const Bytes pairs = part(file, 64, pairBytes);
    Faces result{.format = glFormat(internal, layout, type), .size = width, .rowAlignment = 4};
    result.firstRowBelow = startsBelow(pairs);
    result.faceBytes = result.format.bytesOf(width, result.rowAlignment);
    result.faceStride = (result.faceBytes + 3) / 4 * 4;
    const std::uint64_t first = 64ull + pairBytes;
    if (numberAt<std::uint32_t>(file, first) != result.faceBytes) {
        malformedCube("has another size of a face than its format requires");
    }
    result.bytes = part(file, first + 4, 5 * result.faceStride + result.faceBytes);
    return result;
}

Faces facesOfKtx2(Bytes file, std::uint64_t maxPixels) {
    std::array<std::uint32_t, 13> header{};
    std::memcpy(header.data(), part(file, 12, sizeof header).data(), sizeof header);
    const auto [format, typeSize, width, height, depth, layers, faces, levels, compression,
                descriptor, descriptorBytes, pairsAt, pairBytes] = header;
    if (compression != 0) {
        constexpr std::array kNames{"", "BasisLZ", "Zstandard", "ZLIB"};
        throw ImportError(Reason::unsupported,
                          "KTX2 supercompression (" +
                              (compression < kNames.size() ? std::string(kNames[compression])
                                                           : std::to_string(compression)) +
                              ") is not supported");
    }
    requireCube(width, height, depth, layers, faces);
    requirePixels(width, maxPixels);
    Faces result{.format = vulkanFormat(format), .size = width};
    result.firstRowBelow = startsBelow(part(file, pairsAt, pairBytes));
    result.faceBytes = result.faceStride = result.format.bytesOf(width, 1);
    const auto offset = numberAt<std::uint64_t>(file, 80);
    const auto bytes = numberAt<std::uint64_t>(file, 88);
    if (bytes != 6 * result.faceBytes) {
        malformedCube("has another size of its level than its format requires");
    }
    result.bytes = part(file, offset, bytes);
    return result;
}

// Offsets of DDS_HEADER and DDS_HEADER_DXT10 behind the magic number (Microsoft's reference of
// Direct3D). The faces have OpenGL's order and layout; each is followed by its smaller levels.
Faces facesOfDds(Bytes file, std::uint64_t maxPixels) {
    constexpr std::uint32_t kAllFaces = 0xFE00, kDx10Cube = 4, kTexture2d = 3;
    const auto at = [&](std::uint64_t offset) { return numberAt<std::uint32_t>(file, offset); };
    constexpr std::uint64_t kHeader = 128, kDx10Header = 148;
    part(file, 0, kHeader);
    if (at(4) != 124 || at(76) != 32) malformedCube("has a DDS header of another size");
    const std::uint32_t height = at(12), width = at(16), levels = std::max(1u, at(28));
    const DdsPixels pixels{.flags = at(80), .code = at(84), .bits = at(88), .red = at(92)};
    const bool dx10 = pixels.hasDx10Header();
    const bool cube = dx10 ? at(132) == kTexture2d && (at(136) & kDx10Cube) != 0
                           : (at(112) & kAllFaces) == kAllFaces;
    // Each counts six faces; a header that counts one cube is no array.
    const std::uint32_t layers = dx10 && at(140) > 1 ? at(140) : 0;
    requireCube(width, height, 1, layers, cube ? 6 : 1);
    requirePixels(width, maxPixels);
    if (levels > static_cast<std::uint32_t>(std::bit_width(width))) {
        malformedCube("has more levels than its size allows");
    }
    Faces result{.format = dx10 ? dxgiFormat(at(128)) : ddsFormat(pixels), .size = width};
    result.faceBytes = result.format.bytesOf(width, 1);
    for (std::uint32_t level = 0; level < levels; ++level) {
        result.faceStride += result.format.bytesOf(std::max(1u, width >> level), 1);
    }
    result.bytes =
        part(file, dx10 ? kDx10Header : kHeader, 5 * result.faceStride + result.faceBytes);
    return result;
}

Faces facesOf(Bytes file, std::uint64_t maxPixels) {
    if (opensWith(file, kMagic1)) return facesOfKtx1(file, maxPixels);
    if (opensWith(file, kMagic2)) return facesOfKtx2(file, maxPixels);
    if (opensWith(file, kMagicDds)) return facesOfDds(file, maxPixels);
    malformedCube("is neither KTX nor KTX2 nor DDS");
}

}  // namespace

RadianceCube decodedCube(Bytes file, std::uint64_t maxPixels) {
    const Faces faces = facesOf(file, maxPixels);
    RadianceCube cube{.faceSize = faces.size, .texels = {}};
    const std::size_t faceTexels = std::size_t{faces.size} * faces.size;
    cube.texels.resize(6 * faceTexels);
    for (std::size_t face = 0; face < 6; ++face) {
        faces.format.decode(faces.bytes.subspan(face * static_cast<std::size_t>(faces.faceStride),
                                                static_cast<std::size_t>(faces.faceBytes)),
                            faces.size, faces.rowAlignment,
                            std::span(cube.texels).subspan(face * faceTexels, faceTexels));
        if (!faces.firstRowBelow) continue;
        const auto begin = cube.texels.begin() + static_cast<std::ptrdiff_t>(face * faceTexels);
        for (std::uint32_t y = 0; y < faces.size / 2; ++y) {
            std::swap_ranges(begin + std::ptrdiff_t{y} * faces.size,
                             begin + std::ptrdiff_t{y + 1} * faces.size,
                             begin + std::ptrdiff_t{faces.size - 1 - y} * faces.size);
        }
    }
    return cube;
}

}  // namespace clerestory
