// Bytes of a picture file -> pixels. Asks for the size first, so that a small file cannot make a
// large one.
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// Level 0 only; name and colour space are left to the caller. Throws ImportError: unsupported for a
// format that we do not read, limit when it has over maxPixels or more than is left of the scene's
// allowance `pixelsLeft`, malformed otherwise.
TextureImage decodedImage(std::span<const unsigned char> file, std::uint64_t maxPixels,
                          std::atomic<std::uint64_t>& pixelsLeft);

struct RadianceImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<glm::vec3> texels;  // linear; the first row is the top row
};

bool isExr(std::span<const unsigned char> file);
RadianceImage decodedExr(std::span<const unsigned char> file, std::uint64_t maxPixels);

// .hdr and .exr as they are, 8-bit pictures decoded from sRGB.
RadianceImage decodedRadiance(std::span<const unsigned char> file, std::uint64_t maxPixels);

}  // namespace clerestory
