// Cube maps in KTX and KTX2 files -> linear radiance. Every offset and size in the file is checked
// against the file before anything is read or made.
//
// Reads: three or four channels of 8 or 16 bits, half and single floats, E5B9G9R9, B10G11R11,
// A2B10G10R10; S3TC, BPTC, ETC1 and ETC2 blocks. Does not: supercompression, arrays, plain 2D
// textures, one or two channels, ASTC, PVRTC, big-endian files.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

struct RadianceCube {
    std::uint32_t faceSize = 0;
    std::vector<glm::vec3> texels;  // as EnvironmentMap's, but as the file has them
};

bool isKtx(std::span<const unsigned char> file);

// The largest level. Throws ImportError, which names a format that is not read: unsupported,
// malformed, or limit for more than maxPixels over all faces.
RadianceCube decodedKtxCube(std::span<const unsigned char> file, std::uint64_t maxPixels);

}  // namespace clerestory
