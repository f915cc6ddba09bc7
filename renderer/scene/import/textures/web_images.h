// WebP and AVIF images, by libwebp and libavif: what image_decoder.h calls.
#pragma once

#include "scene/material.h"

#include <cstdint>
#include <functional>
#include <span>

namespace clerestory {

// Called with the size that the header declares, before anything of that size is allocated; throws
// if it is too large.
using AdmitSize = std::function<void(std::uint32_t width, std::uint32_t height)>;

bool isWebp(std::span<const unsigned char> file);
bool isAvif(std::span<const unsigned char> file);

// Level 0, 8 bits a channel, alpha not premultiplied; of an AVIF of more bits, rounded. Throw
// ImportError: unsupported for animations, malformed, and what `admit` throws.
TextureImage decodedWebp(std::span<const unsigned char> file, const AdmitSize& admit);
TextureImage decodedAvif(std::span<const unsigned char> file, const AdmitSize& admit);

}  // namespace clerestory
