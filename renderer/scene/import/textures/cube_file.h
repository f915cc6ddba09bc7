// Cube maps in KTX, KTX2 and DDS files, in the calling process. Every offset and size in a file is
// checked against the file's size before it is used.
//
// Three or four channels of 8 or 16 bits, half and single floats, E5B9G9R9, B10G11R11,
// A2B10G10R10; S3TC, BPTC, ETC1 and ETC2 blocks. Does not: supercompression, arrays, plain 2D
// textures, one or two channels, ASTC, PVRTC, big-endian files. Eight bits of DDS files without a
// DX10 header are sRGB, for these name no colour space.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

struct RadianceCube {
    std::uint32_t faceSize = 0;
    std::vector<glm::vec3> texels;  // in the order of EnvironmentMap, values as in the file
};

// Decodes the largest level. Throws ImportError: unsupported, with the format; malformed; or limit
// for more than maxPixels over all faces.
RadianceCube decodedCube(std::span<const unsigned char> file, std::uint64_t maxPixels);

}  // namespace clerestory
