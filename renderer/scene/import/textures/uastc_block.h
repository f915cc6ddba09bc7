// Blocks of UASTC LDR 4x4, a subset of ASTC with a simpler encoding: the universal format of
// textures in KTX2 files. Written from "UASTC Texture Specification" (Binomial) and from the
// chapters on ASTC of the Khronos Data Format Specification.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace clerestory {

inline constexpr std::size_t kUastcBlockBytes = 16;

// Sixteen texels row by row, RGBA.
using UastcTexels = std::array<std::array<std::uint8_t, 4>, 16>;

// Nothing for the reserved mode and for partition patterns that do not exist.
std::optional<UastcTexels> decodedUastc(std::span<const unsigned char, kUastcBlockBytes> block);

}  // namespace clerestory
