#include "scene/import/textures/texel_format.h"

#include "scene/import/base/types.h"
#include "scene/srgb.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace clerestory {
namespace {

using Bytes = std::span<const unsigned char>;

struct Known {
    std::uint32_t number;
    const char* name;
    std::optional<TexelFormat> format;  // none: known, but not supported
};

TexelFormat plain(TexelKind kind, std::uint32_t channels, bool blueFirst = false,
                  bool srgb = false) {
    return {.kind = kind, .channels = channels, .blueFirst = blueFirst, .srgb = srgb};
}
TexelFormat packed(TexelKind kind) {
    return {.kind = kind};
}
TexelFormat blocks(BlockFormat format, bool srgb = false) {
    return {.srgb = srgb, .block = format};
}

const std::vector<Known>& vulkanFormats() {
    using enum TexelKind;
    using enum BlockFormat;
    static const std::vector<Known> all{
        {0, "UNDEFINED (a universal texture)", {}},
        {9, "R8_UNORM", {}},
        {15, "R8_SRGB", {}},
        {16, "R8G8_UNORM", {}},
        {23, "R8G8B8_UNORM", plain(unorm8, 3)},
        {29, "R8G8B8_SRGB", plain(unorm8, 3, false, true)},
        {30, "B8G8R8_UNORM", plain(unorm8, 3, true)},
        {36, "B8G8R8_SRGB", plain(unorm8, 3, true, true)},
        {37, "R8G8B8A8_UNORM", plain(unorm8, 4)},
        {43, "R8G8B8A8_SRGB", plain(unorm8, 4, false, true)},
        {44, "B8G8R8A8_UNORM", plain(unorm8, 4, true)},
        {50, "B8G8R8A8_SRGB", plain(unorm8, 4, true, true)},
        {64, "A2B10G10R10_UNORM_PACK32", packed(a2b10g10r10)},
        {70, "R16_UNORM", {}},
        {76, "R16_SFLOAT", {}},
        {83, "R16G16_SFLOAT", {}},
        {84, "R16G16B16_UNORM", plain(unorm16, 3)},
        {90, "R16G16B16_SFLOAT", plain(half, 3)},
        {91, "R16G16B16A16_UNORM", plain(unorm16, 4)},
        {97, "R16G16B16A16_SFLOAT", plain(half, 4)},
        {100, "R32_SFLOAT", {}},
        {106, "R32G32B32_SFLOAT", plain(single, 3)},
        {109, "R32G32B32A32_SFLOAT", plain(single, 4)},
        {122, "B10G11R11_UFLOAT_PACK32", packed(b10g11r11)},
        {123, "E5B9G9R9_UFLOAT_PACK32", packed(e5b9g9r9)},
        {131, "BC1_RGB_UNORM_BLOCK", blocks(bc1)},
        {132, "BC1_RGB_SRGB_BLOCK", blocks(bc1, true)},
        {133, "BC1_RGBA_UNORM_BLOCK", blocks(bc1)},
        {134, "BC1_RGBA_SRGB_BLOCK", blocks(bc1, true)},
        {135, "BC2_UNORM_BLOCK", blocks(bc3)},
        {136, "BC2_SRGB_BLOCK", blocks(bc3, true)},
        {137, "BC3_UNORM_BLOCK", blocks(bc3)},
        {138, "BC3_SRGB_BLOCK", blocks(bc3, true)},
        {139, "BC4_UNORM_BLOCK", {}},
        {140, "BC4_SNORM_BLOCK", {}},
        {141, "BC5_UNORM_BLOCK", {}},
        {142, "BC5_SNORM_BLOCK", {}},
        {143, "BC6H_UFLOAT_BLOCK", blocks(bc6hUnsigned)},
        {144, "BC6H_SFLOAT_BLOCK", blocks(bc6hSigned)},
        {145, "BC7_UNORM_BLOCK", blocks(bc7)},
        {146, "BC7_SRGB_BLOCK", blocks(bc7, true)},
        {147, "ETC2_R8G8B8_UNORM_BLOCK", blocks(etc2)},
        {148, "ETC2_R8G8B8_SRGB_BLOCK", blocks(etc2, true)},
        {149, "ETC2_R8G8B8A1_UNORM_BLOCK", blocks(etc2Punchthrough)},
        {150, "ETC2_R8G8B8A1_SRGB_BLOCK", blocks(etc2Punchthrough, true)},
        {151, "ETC2_R8G8B8A8_UNORM_BLOCK", blocks(etc2Alpha)},
        {152, "ETC2_R8G8B8A8_SRGB_BLOCK", blocks(etc2Alpha, true)},
        {153, "EAC_R11_UNORM_BLOCK", {}},
        {155, "EAC_R11G11_UNORM_BLOCK", {}},
        {157, "ASTC_4x4_UNORM_BLOCK", {}},
        {158, "ASTC_4x4_SRGB_BLOCK", {}},
    };
    return all;
}

const std::vector<Known>& glBlockFormats() {
    using enum BlockFormat;
    static const std::vector<Known> all{
        {0x83F0, "COMPRESSED_RGB_S3TC_DXT1", blocks(bc1)},
        {0x83F1, "COMPRESSED_RGBA_S3TC_DXT1", blocks(bc1)},
        {0x83F2, "COMPRESSED_RGBA_S3TC_DXT3", blocks(bc3)},
        {0x83F3, "COMPRESSED_RGBA_S3TC_DXT5", blocks(bc3)},
        {0x8C4C, "COMPRESSED_SRGB_S3TC_DXT1", blocks(bc1, true)},
        {0x8C4D, "COMPRESSED_SRGB_ALPHA_S3TC_DXT1", blocks(bc1, true)},
        {0x8C4E, "COMPRESSED_SRGB_ALPHA_S3TC_DXT3", blocks(bc3, true)},
        {0x8C4F, "COMPRESSED_SRGB_ALPHA_S3TC_DXT5", blocks(bc3, true)},
        {0x8DBB, "COMPRESSED_RED_RGTC1", {}},
        {0x8DBD, "COMPRESSED_RG_RGTC2", {}},
        {0x8E8C, "COMPRESSED_RGBA_BPTC_UNORM", blocks(bc7)},
        {0x8E8D, "COMPRESSED_SRGB_ALPHA_BPTC_UNORM", blocks(bc7, true)},
        {0x8E8E, "COMPRESSED_RGB_BPTC_SIGNED_FLOAT", blocks(bc6hSigned)},
        {0x8E8F, "COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT", blocks(bc6hUnsigned)},
        {0x8D64, "ETC1_RGB8", blocks(etc2)},
        {0x9270, "COMPRESSED_R11_EAC", {}},
        {0x9272, "COMPRESSED_RG11_EAC", {}},
        {0x9274, "COMPRESSED_RGB8_ETC2", blocks(etc2)},
        {0x9275, "COMPRESSED_SRGB8_ETC2", blocks(etc2, true)},
        {0x9276, "COMPRESSED_RGB8_PUNCHTHROUGH_ALPHA1_ETC2", blocks(etc2Punchthrough)},
        {0x9277, "COMPRESSED_SRGB8_PUNCHTHROUGH_ALPHA1_ETC2", blocks(etc2Punchthrough, true)},
        {0x9278, "COMPRESSED_RGBA8_ETC2_EAC", blocks(etc2Alpha)},
        {0x9279, "COMPRESSED_SRGB8_ALPHA8_ETC2_EAC", blocks(etc2Alpha, true)},
    };
    return all;
}

[[noreturn]] void refuse(const std::string& format) {
    throw ImportError(ImportError::Reason::unsupported,
                      "a cube map of the format " + format + " is not read");
}

std::string hexadecimal(std::uint32_t number) {
    char text[16];
    std::snprintf(text, sizeof text, "0x%04X", number);
    return text;
}

TexelFormat found(const std::vector<Known>& all, std::uint32_t number,
                  const std::string& fallback) {
    const auto known =
        std::find_if(all.begin(), all.end(), [&](const Known& k) { return k.number == number; });
    if (known == all.end()) refuse(fallback);
    if (!known->format) refuse(known->name);
    return *known->format;
}

float floatFromHalf(std::uint32_t bits) {
    const int exponent = static_cast<int>((bits >> 10) & 31);
    const auto fraction = static_cast<float>(bits & 1023);
    if (exponent == 31)
        return (bits & 1023) ? std::nanf("") : (bits & 0x8000 ? -1.0f : 1.0f) * INFINITY;
    const float size =
        exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024.0f + fraction, exponent - 25);
    return bits & 0x8000 ? -size : size;
}

// Unsigned float with a 5-bit exponent.
float fromSmallFloat(std::uint32_t bits, int fractionBits) {
    return floatFromHalf(bits << (10 - fractionBits));
}

glm::vec3 linearFromSrgb(const glm::vec3& c) {
    return {clerestory::linearFromSrgb(c.x), clerestory::linearFromSrgb(c.y),
            clerestory::linearFromSrgb(c.z)};
}

std::uint32_t channelBytes(TexelKind kind) {
    switch (kind) {
        case TexelKind::unorm8:
            return 1;
        case TexelKind::unorm16:
        case TexelKind::half:
            return 2;
        default:
            return 4;
    }
}

bool isPacked(TexelKind kind) {
    return kind == TexelKind::e5b9g9r9 || kind == TexelKind::b10g11r11 ||
           kind == TexelKind::a2b10g10r10;
}

std::uint32_t texelBytes(const TexelFormat& format) {
    return isPacked(format.kind) ? 4 : format.channels * channelBytes(format.kind);
}

float channelAt(TexelKind kind, const unsigned char* at) {
    std::uint16_t two = 0;
    float four = 0.0f;
    switch (kind) {
        case TexelKind::unorm8:
            return static_cast<float>(*at) / 255.0f;
        case TexelKind::unorm16:
            std::memcpy(&two, at, 2);
            return static_cast<float>(two) / 65535.0f;
        case TexelKind::half:
            std::memcpy(&two, at, 2);
            return floatFromHalf(two);
        default:
            std::memcpy(&four, at, 4);
            return four;
    }
}

glm::vec3 fromPacked(TexelKind kind, const unsigned char* at) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, at, 4);
    if (kind == TexelKind::b10g11r11) {
        return {fromSmallFloat(bits & 2047, 6), fromSmallFloat((bits >> 11) & 2047, 6),
                fromSmallFloat(bits >> 22, 5)};
    }
    const bool shared = kind == TexelKind::e5b9g9r9;
    const int width = shared ? 9 : 10;
    const std::uint32_t mask = (1u << width) - 1;
    const glm::vec3 parts(static_cast<float>(bits & mask),
                          static_cast<float>((bits >> width) & mask),
                          static_cast<float>((bits >> (2 * width)) & mask));
    // The exponent bias is 15; fractions have nine bits.
    return shared ? parts * std::ldexp(1.0f, static_cast<int>(bits >> 27) - 24) : parts / 1023.0f;
}

glm::vec3 texelAt(const TexelFormat& format, const unsigned char* at) {
    if (isPacked(format.kind)) return fromPacked(format.kind, at);
    const std::uint32_t step = channelBytes(format.kind);
    glm::vec3 color;
    for (std::uint32_t c = 0; c < 3; ++c) {
        color[static_cast<int>(format.blueFirst ? 2 - c : c)] =
            channelAt(format.kind, at + c * step);
    }
    return color;
}

}  // namespace

std::uint64_t TexelFormat::bytesOf(std::uint32_t size, std::uint64_t rowAlignment) const {
    if (block) {
        const std::uint64_t edge = (std::uint64_t{size} + 3) / 4;
        return edge * edge * blockBytes(*block);
    }
    const std::uint64_t row = std::uint64_t{size} * texelBytes(*this);
    return size * ((row + rowAlignment - 1) / rowAlignment * rowAlignment);
}

void TexelFormat::decode(Bytes bytes, std::uint32_t size, std::uint64_t rowAlignment,
                         std::span<glm::vec3> texels) const {
    if (block) {
        const std::size_t each = blockBytes(*block), edge = (std::size_t{size} + 3) / 4;
        for (std::size_t i = 0; i < edge * edge; ++i) {
            const BlockTexels colors = decodedBlock(*block, bytes.subspan(i * each, each));
            for (std::size_t k = 0; k < 16; ++k) {
                const std::size_t x = 4 * (i % edge) + k % 4, y = 4 * (i / edge) + k / 4;
                if (x < size && y < size) texels[y * size + x] = colors[k];
            }
        }
    } else {
        const auto row = static_cast<std::size_t>(bytesOf(size, rowAlignment) / size);
        const std::size_t step = texelBytes(*this);
        for (std::size_t y = 0; y < size; ++y) {
            for (std::size_t x = 0; x < size; ++x) {
                texels[y * size + x] = texelAt(*this, bytes.data() + y * row + x * step);
            }
        }
    }
    if (!srgb) return;
    for (glm::vec3& texel : texels) texel = linearFromSrgb(texel);
}

TexelFormat vulkanFormat(std::uint32_t format) {
    return found(vulkanFormats(), format, "VkFormat " + std::to_string(format));
}

TexelFormat glFormat(std::uint32_t internal, std::uint32_t layout, std::uint32_t type) {
    const std::string name = "GL internal format " + hexadecimal(internal) + ", format " +
                             hexadecimal(layout) + ", type " + hexadecimal(type);
    if (type == 0) return found(glBlockFormats(), internal, name);
    const bool blueFirst = layout == 0x80E0 || layout == 0x80E1;  // BGR, BGRA
    const bool four = layout == 0x1908 || layout == 0x80E1;       // RGBA, BGRA
    if (!four && !blueFirst && layout != 0x1907) refuse(name);    // RGB
    const bool srgb = internal >= 0x8C40 && internal <= 0x8C43;
    const std::uint32_t channels = four ? 4 : 3;
    switch (type) {
        case 0x1401:  // UNSIGNED_BYTE
            return plain(TexelKind::unorm8, channels, blueFirst, srgb);
        case 0x1403:  // UNSIGNED_SHORT
            return plain(TexelKind::unorm16, channels, blueFirst);
        case 0x140B:  // HALF_FLOAT
            return plain(TexelKind::half, channels, blueFirst);
        case 0x1406:  // FLOAT
            return plain(TexelKind::single, channels, blueFirst);
        case 0x8C3E:  // UNSIGNED_INT_5_9_9_9_REV
            return packed(TexelKind::e5b9g9r9);
        case 0x8C3B:  // UNSIGNED_INT_10F_11F_11F_REV
            return packed(TexelKind::b10g11r11);
        case 0x8368:  // UNSIGNED_INT_2_10_10_10_REV
            if (blueFirst) refuse(name);
            return packed(TexelKind::a2b10g10r10);
        default:
            refuse(name);
    }
}

namespace {

struct SameFormat {
    std::uint32_t direct3d, vulkan;
};

TexelFormat sameFormat(std::span<const SameFormat> all, std::uint32_t number,
                       const std::string& name) {
    for (const SameFormat& same : all) {
        if (same.direct3d == number) return vulkanFormat(same.vulkan);
    }
    refuse(name);
}

constexpr std::uint32_t fourCharacters(const char (&code)[5]) {
    std::uint32_t number = 0;
    for (int i = 3; i >= 0; --i) number = number << 8 | static_cast<unsigned char>(code[i]);
    return number;
}

constexpr std::uint32_t kHasFourCharacters = 4, kHasMasks = 0x40;

}  // namespace

// Numbers of DXGI_FORMAT and VkFormat.
TexelFormat dxgiFormat(std::uint32_t format) {
    static constexpr SameFormat kSame[]{
        {2, 109},  {6, 106},  {10, 97},  {11, 91},  {24, 64},  {26, 122}, {28, 37},  {29, 43},
        {67, 123}, {71, 133}, {72, 134}, {74, 135}, {75, 136}, {77, 137}, {78, 138}, {87, 44},
        {88, 44},  {91, 50},  {93, 50},  {95, 143}, {96, 144}, {98, 145}, {99, 146}};
    return sameFormat(kSame, format, "DXGI_FORMAT " + std::to_string(format));
}

bool DdsPixels::hasDx10Header() const {
    return (flags & kHasFourCharacters) != 0 && code == fourCharacters("DX10");
}

TexelFormat ddsFormat(const DdsPixels& pixels) {
    if (pixels.flags & kHasFourCharacters) {
        static constexpr SameFormat kSame[]{{36, 91},    // D3DFMT_A16B16G16R16
                                            {113, 97},   // A16B16G16R16F
                                            {116, 109},  // A32B32G32R32F
                                            {fourCharacters("DXT1"), 134},
                                            {fourCharacters("DXT2"), 136},
                                            {fourCharacters("DXT3"), 136},
                                            {fourCharacters("DXT4"), 138},
                                            {fourCharacters("DXT5"), 138}};
        return sameFormat(kSame, pixels.code, "DDS code " + hexadecimal(pixels.code));
    }
    const std::string name = "DDS with " + std::to_string(pixels.bits) +
                             " bits a texel and the red mask " + hexadecimal(pixels.red);
    const bool bytes = pixels.bits == 24 || pixels.bits == 32;
    const bool redFirst = pixels.red == 0xFF, redLast = pixels.red == 0xFF0000;
    if (!(pixels.flags & kHasMasks) || !bytes || (!redFirst && !redLast)) refuse(name);
    return plain(TexelKind::unorm8, pixels.bits / 8, redLast, true);
}

}  // namespace clerestory
