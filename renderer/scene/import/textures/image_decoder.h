// Image files -> texels. Checks the size in the header first: a small file can declare a huge
// image.
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// Level 0 only; does not set name and colour space. Throws ImportError: unsupported for other
// formats, limit if the image has more than maxPixels or more than pixelsLeft, the scene's
// remaining allowance; malformed otherwise.
TextureImage decodedImage(std::span<const unsigned char> file, std::uint64_t maxPixels,
                          std::atomic<std::uint64_t>& pixelsLeft);

struct RadianceImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<glm::vec3> texels;  // linear; the first row is the top row
};

bool isExr(std::span<const unsigned char> file);
RadianceImage decodedExr(std::span<const unsigned char> file, std::uint64_t maxPixels);

// .hdr and .exr without conversion; 8-bit images converted from sRGB.
RadianceImage decodedRadiance(std::span<const unsigned char> file, std::uint64_t maxPixels);

}  // namespace clerestory
