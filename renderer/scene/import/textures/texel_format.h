// Texel formats of KTX and DDS files, by the constants of OpenGL, Vulkan and Direct3D; and decoders
// of their compressed blocks of 4 x 4 texels. Any bytes are a valid block; no decoder reads beyond
// it.
//
// Does not: decode alpha (environment maps have none), formats of one or two channels, ASTC, PVRTC.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace clerestory {

enum class BlockFormat {
    bc1,               // S3TC DXT1, with or without 1-bit alpha
    bc3,               // the colours of DXT3 and DXT5, which are equal
    bc6hUnsigned,      // BPTC, half floats
    bc6hSigned,        // signed
    bc7,               // BPTC, 8 bits
    etc2,              // and ETC1
    etc2Punchthrough,  // with 1-bit alpha
    etc2Alpha          // with eight bits
};

std::size_t blockBytes(BlockFormat format);

// Sixteen texels row by row; 0..1 as stored (the caller converts sRGB), BC6H without conversion.
using BlockTexels = std::array<glm::vec3, 16>;
BlockTexels decodedBlock(BlockFormat format, std::span<const unsigned char> block);

// The decoders of each family; `block` has blockBytes().
BlockTexels decodedS3tc(std::span<const unsigned char> block, bool hasFourColoursOnly);
BlockTexels decodedEtc2(std::span<const unsigned char> block, bool punchthrough);
BlockTexels decodedBc6h(std::span<const unsigned char> block, bool isSigned);
BlockTexels decodedBc7(std::span<const unsigned char> block);

// Of uncompressed texels.
enum class TexelKind { unorm8, unorm16, half, single, e5b9g9r9, b10g11r11, a2b10g10r10 };

struct TexelFormat {
    TexelKind kind = TexelKind::unorm8;
    std::uint32_t channels = 4;  // of unorm8 to single: 3 or 4; the fourth is ignored
    bool blueFirst = false;
    bool srgb = false;                 // 8 bits and blocks: decoded to linear
    std::optional<BlockFormat> block;  // replaces all members but srgb

    // Size of a square image whose rows are aligned to rowAlignment bytes.
    std::uint64_t bytesOf(std::uint32_t size, std::uint64_t rowAlignment) const;
    // `bytes` has bytesOf(); `texels` has size * size.
    void decode(std::span<const unsigned char> bytes, std::uint32_t size,
                std::uint64_t rowAlignment, std::span<glm::vec3> texels) const;
};

// These throw ImportError (unsupported) with the format's number. `layout` and `type` are those of
// glTexImage2D, both 0 for blocks.
TexelFormat glFormat(std::uint32_t internal, std::uint32_t layout, std::uint32_t type);
TexelFormat vulkanFormat(std::uint32_t format);
TexelFormat dxgiFormat(std::uint32_t format);

// DDS_PIXELFORMAT, without the masks that follow from the red one.
struct DdsPixels {
    std::uint32_t flags = 0;
    std::uint32_t code = 0;  // four characters, or a number of D3DFORMAT
    std::uint32_t bits = 0;  // of a texel
    std::uint32_t red = 0;   // mask

    bool hasDx10Header() const;
};
TexelFormat ddsFormat(const DdsPixels& pixels);

}  // namespace clerestory
