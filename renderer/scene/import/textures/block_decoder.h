// Decodes compressed blocks of 4 x 4 texels. Any bytes are a valid block; no decoder reads beyond
// it.
//
// Does not: decode alpha (environment maps have none), formats of one or two channels, ASTC, PVRTC.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
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

}  // namespace clerestory
