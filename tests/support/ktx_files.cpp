#include "tests/support/ktx_files.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace clerestory::test {
namespace {

template <class T>
void put(std::string& file, T value) {
    file.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void pad(std::string& file, std::size_t multiple) {
    while (file.size() % multiple != 0) file += '\0';
}

std::uint8_t byteOf(float x) {
    return static_cast<std::uint8_t>(std::lround(255.0f * x));
}
float srgb(float x) {
    return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

void putTexel(std::string& file, const glm::vec3& c, KtxFormat format) {
    switch (format) {
        case KtxFormat::unorm3:
        case KtxFormat::unorm4:
            for (int i = 0; i < 3; ++i) put(file, byteOf(c[i]));
            if (format == KtxFormat::unorm4) put(file, std::uint8_t{77});
            break;
        case KtxFormat::bgr4:
            for (int i = 2; i >= 0; --i) put(file, byteOf(c[i]));
            put(file, std::uint8_t{77});
            break;
        case KtxFormat::srgb4:
            for (int i = 0; i < 3; ++i) put(file, byteOf(srgb(c[i])));
            put(file, std::uint8_t{77});
            break;
        case KtxFormat::wide3:
            for (int i = 0; i < 3; ++i) {
                put(file, static_cast<std::uint16_t>(std::lround(65535.0f * c[i])));
            }
            break;
        case KtxFormat::half3:
        case KtxFormat::half4:
            for (int i = 0; i < 3; ++i) put(file, glm::packHalf1x16(c[i]));
            if (format == KtxFormat::half4) put(file, glm::packHalf1x16(0.3f));
            break;
        case KtxFormat::single3:
        case KtxFormat::single4:
            for (int i = 0; i < 3; ++i) put(file, c[i]);
            if (format == KtxFormat::single4) put(file, 0.3f);
            break;
        case KtxFormat::sharedExponent:
            put(file, glm::packF3x9_E1x5(c));
            break;
        case KtxFormat::small:
            put(file, glm::packF2x11_1x10(c));
            break;
        case KtxFormat::bc1:
            break;
    }
}

std::string faceOf(const Cube& cube, std::uint32_t face, KtxFormat format,
                   std::size_t rowMultiple) {
    std::string bytes;
    const auto at = [&](std::uint32_t x, std::uint32_t y) {
        return cube.texels[(std::size_t{face} * cube.size + y) * cube.size + x];
    };
    if (format == KtxFormat::bc1) {
        for (std::uint32_t y = 0; y < cube.size; y += 4) {
            for (std::uint32_t x = 0; x < cube.size; x += 4) {
                const glm::vec3 c = 0.5f * (at(x + 1, y + 1) + at(x + 2, y + 2));
                const auto color =
                    static_cast<std::uint16_t>(std::lround(31 * c.x) << 11 |
                                               std::lround(63 * c.y) << 5 | std::lround(31 * c.z));
                put(bytes, color);
                put(bytes, color);
                put(bytes, std::uint32_t{0});
            }
        }
        return bytes;
    }
    for (std::uint32_t y = 0; y < cube.size; ++y) {
        for (std::uint32_t x = 0; x < cube.size; ++x) putTexel(bytes, at(x, y), format);
        pad(bytes, rowMultiple);
    }
    return bytes;
}

struct Numbers {
    std::uint32_t type, layout, internal, vulkan;
};
Numbers numbersOf(KtxFormat format) {
    switch (format) {
        case KtxFormat::unorm3:
            return {0x1401, 0x1907, 0x8051, 23};
        case KtxFormat::unorm4:
            return {0x1401, 0x1908, 0x8058, 37};
        case KtxFormat::bgr4:
            return {0x1401, 0x80E1, 0x8058, 44};
        case KtxFormat::srgb4:
            return {0x1401, 0x1908, 0x8C43, 43};
        case KtxFormat::wide3:
            return {0x1403, 0x1907, 0x8054, 84};
        case KtxFormat::half3:
            return {0x140B, 0x1907, 0x881B, 90};
        case KtxFormat::half4:
            return {0x140B, 0x1908, 0x881A, 97};
        case KtxFormat::single3:
            return {0x1406, 0x1907, 0x8815, 106};
        case KtxFormat::single4:
            return {0x1406, 0x1908, 0x8814, 109};
        case KtxFormat::sharedExponent:
            return {0x8C3E, 0x1907, 0x8C3D, 123};
        case KtxFormat::small:
            return {0x8C3B, 0x1907, 0x8C3A, 122};
        case KtxFormat::bc1:
            return {0, 0, 0x83F0, 131};
    }
    return {};
}

std::string pairBytes(const std::string& pair) {
    std::string bytes;
    if (pair.empty()) return bytes;
    put(bytes, static_cast<std::uint32_t>(pair.size() + 1));
    bytes += pair;
    bytes += '\0';
    pad(bytes, 4);
    return bytes;
}

}  // namespace

std::string ktx1File(const Cube& cube, KtxFormat format, const std::string& pair) {
    const Numbers n = numbersOf(format);
    const std::string pairs = pairBytes(pair);
    std::string file("\xABKTX 11\xBB\r\n\x1A\n", 12);
    const std::uint32_t typeSize = n.type == 0x140B || n.type == 0x1403 ? 2
                                   : n.type == 0x1401                   ? 1
                                                                        : 4;
    for (const std::uint32_t value :
         {0x04030201u, n.type, typeSize, n.layout, n.internal, 0x1908u, cube.size, cube.size, 0u,
          0u, 6u, 1u, static_cast<std::uint32_t>(pairs.size())}) {
        put(file, value);
    }
    file += pairs;
    for (std::uint32_t face = 0; face < 6; ++face) {
        const std::string bytes = faceOf(cube, face, format, 4);
        if (face == 0) put(file, static_cast<std::uint32_t>(bytes.size()));
        file += bytes;
        pad(file, 4);
    }
    return file;
}

std::string ktx2File(const Cube& cube, KtxFormat format, const std::string& pair) {
    const std::string pairs = pairBytes(pair);
    std::string faces;
    for (std::uint32_t face = 0; face < 6; ++face) faces += faceOf(cube, face, format, 1);
    std::string file("\xABKTX 20\xBB\r\n\x1A\n", 12);
    const std::uint32_t pairsAt = 80 + 24;
    for (const std::uint32_t value :
         {numbersOf(format).vulkan, 1u, cube.size, cube.size, 0u, 0u, 6u, 1u, 0u, 0u, 0u,
          pairs.empty() ? 0u : pairsAt, static_cast<std::uint32_t>(pairs.size())}) {
        put(file, value);
    }
    put(file, std::uint64_t{0});
    put(file, std::uint64_t{0});
    std::uint64_t offset = (pairsAt + pairs.size() + 15) / 16 * 16;
    put(file, offset);
    put(file, static_cast<std::uint64_t>(faces.size()));
    put(file, static_cast<std::uint64_t>(faces.size()));
    file += pairs;
    file.resize(offset);
    return file + faces;
}

std::string ddsFile(const Cube& cube, KtxFormat format, std::uint32_t dxgi, std::uint32_t levels) {
    std::string file("DDS ", 4);
    for (const std::uint32_t value : {124u, 0x21007u, cube.size, cube.size, 0u, 0u, levels}) {
        put(file, value);
    }
    file.append(44, '\0');
    const std::uint32_t code = dxgi != 0                      ? 0x30315844  // DX10
                               : format == KtxFormat::half4   ? 113
                               : format == KtxFormat::single4 ? 116
                                                              : 0;
    const bool three = format == KtxFormat::unorm3;
    const std::uint32_t bits = code != 0 ? 0 : three ? 24 : 32;
    const bool blueFirst = format == KtxFormat::bgr4;
    for (const std::uint32_t value :
         {32u, code != 0 ? 4u : 0x40u, code, bits, blueFirst ? 0xFF0000u : 0xFFu, 0xFF00u,
          blueFirst ? 0xFFu : 0xFF0000u, three ? 0u : 0xFF000000u, 0x1008u,
          dxgi != 0 ? 0u : 0xFE00u, 0u, 0u, 0u}) {
        put(file, value);
    }
    if (dxgi != 0) {
        for (const std::uint32_t value : {dxgi, 3u, 4u, 1u, 0u}) put(file, value);
    }
    for (std::uint32_t face = 0; face < 6; ++face) {
        file += faceOf(cube, face, format, 1);
        for (std::uint32_t level = 1; level < levels; ++level) {
            const std::uint32_t size = std::max(1u, cube.size >> level);
            const Cube black{size, std::vector<glm::vec3>(std::size_t{6} * size * size)};
            file += faceOf(black, face, format, 1);
        }
    }
    return file;
}

}  // namespace clerestory::test
