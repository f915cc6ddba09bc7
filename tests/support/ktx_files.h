// Writes cube maps as KTX, KTX2 and DDS files, from the formats' specifications, for tests of the
// reader.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace clerestory::test {

struct Cube {
    std::uint32_t size = 0;
    std::vector<glm::vec3> texels;  // face by face in OpenGL's order and layout
};

enum class KtxFormat {
    unorm3,
    unorm4,
    bgr4,
    srgb4,
    wide3,  // 16 bits
    half3,
    half4,
    single3,
    single4,
    sharedExponent,
    small,  // 11, 11 and 10 bits
    bc1     // blocks of one colour: the size is a multiple of 4
};

// `pairs`: one key and value with the zero between, or nothing.
std::string ktx1File(const Cube& cube, KtxFormat format, const std::string& pair = "");
std::string ktx2File(const Cube& cube, KtxFormat format, const std::string& pair = "");

// dxgi: the number of the format, with a DX10 header; 0: none. levels: the smaller ones are zeros.
std::string ddsFile(const Cube& cube, KtxFormat format, std::uint32_t dxgi,
                    std::uint32_t levels = 1);

}  // namespace clerestory::test
