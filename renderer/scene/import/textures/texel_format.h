// Texel formats of KTX files, by the constants of OpenGL and Vulkan.
#pragma once

#include "scene/import/textures/block_decoder.h"

#include <cstdint>
#include <optional>

namespace clerestory {

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

// Both throw ImportError (unsupported) with the format's number. `layout` and `type` are those of
// glTexImage2D, both 0 for blocks.
TexelFormat glFormat(std::uint32_t internal, std::uint32_t layout, std::uint32_t type);
TexelFormat vulkanFormat(std::uint32_t format);

}  // namespace clerestory
