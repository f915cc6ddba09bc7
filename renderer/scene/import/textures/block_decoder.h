// Blocks of 4 x 4 texels as graphics hardware takes them -> colours. Any bytes are some block: none
// is refused, none reads beyond its own bytes.
//
// Does not: coverage (an environment map has none), formats of one or two channels, ASTC, PVRTC.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <span>

namespace clerestory {

enum class BlockFormat {
    bc1,               // S3TC DXT1, with or without its one bit of coverage
    bc3,               // the colours of DXT3 and DXT5, which are stored alike
    bc6hUnsigned,      // BPTC, half floats
    bc6hSigned,        // the same with a sign
    bc7,               // BPTC, 8 bits
    etc2,              // and ETC1
    etc2Punchthrough,  // with one bit of coverage
    etc2Alpha          // with eight
};

std::size_t blockBytes(BlockFormat format);

// Sixteen texels row by row; 0..1 as stored (sRGB is the caller's to know), BC6H as they are.
using BlockTexels = std::array<glm::vec3, 16>;
BlockTexels decodedBlock(BlockFormat format, std::span<const unsigned char> block);

// The readers of each family; `block` has blockBytes().
BlockTexels decodedS3tc(std::span<const unsigned char> block, bool hasFourColoursOnly);
BlockTexels decodedEtc2(std::span<const unsigned char> block, bool punchthrough);
BlockTexels decodedBc6h(std::span<const unsigned char> block, bool isSigned);
BlockTexels decodedBc7(std::span<const unsigned char> block);

}  // namespace clerestory
