// Environment maps with a known radiance in every direction, in every container.
#pragma once

#include "image/image.h"
#include "tests/support/ktx_files.h"
#include "tests/unit/import_support.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>

namespace clerestory {

using test::Cube;
using test::KtxFormat;

// Tells every direction from every other, and no mirror image or turn of it is the same.
inline glm::vec3 lightFrom(const glm::vec3& direction) {
    const glm::vec3 d = glm::normalize(direction);
    return glm::vec3(0.5f) + 0.4f * glm::vec3(d.x, d.y, d.z) + glm::vec3(0, 0, 0.1f * d.x * d.y);
}

inline Cube analyticCube(std::uint32_t size) {
    Cube cube{size, {}};
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < size; ++y) {
            for (std::uint32_t x = 0; x < size; ++x) {
                cube.texels.push_back(lightFrom(cubeTexelDirection(face, x, y, size)));
            }
        }
    }
    return cube;
}

// `error` on each channel of each texel.
inline void expectAnalytic(const EnvironmentMap& map, double error, const std::string& about) {
    ASSERT_GT(map.faceSize, 0u) << about;
    ASSERT_EQ(map.texels.size(), std::size_t{6} * map.faceSize * map.faceSize);
    double worst = 0.0;
    std::size_t i = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x, ++i) {
                const glm::vec3 expected = lightFrom(cubeTexelDirection(face, x, y, map.faceSize));
                for (int c = 0; c < 3; ++c) {
                    worst = std::max<double>(worst, std::abs(map.texels[i][c] - expected[c]));
                }
            }
        }
    }
    EXPECT_LT(worst, error) << about;
}

inline std::string ktxFile(const Cube& cube, KtxFormat format, bool second) {
    return second ? test::ktx2File(cube, format) : test::ktx1File(cube, format);
}

inline Image linearImage(std::uint32_t width, std::uint32_t height,
                         const std::function<glm::vec3(std::uint32_t, std::uint32_t)>& at) {
    Image image = makeImage(width, height, 3, PixelType::float32);
    float* out = image.floats();
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x, out += 3) {
            const glm::vec3 color = at(x, y);
            std::copy(&color.x, &color.x + 3, out);
        }
    }
    return image;
}

// Once round from +Z over +X, and from straight up to straight down; -Z in the middle.
inline Image panorama(std::uint32_t width) {
    return linearImage(width, width / 2, [&](std::uint32_t x, std::uint32_t y) {
        const float turn = 6.28318531f * ((float(x) + 0.5f) / float(width) - 0.5f);
        const float fall = 3.14159265f * (float(y) + 0.5f) / float(width / 2);
        return lightFrom(
            {std::sin(fall) * std::sin(turn), std::cos(fall), -std::sin(fall) * std::cos(turn)});
    });
}

// Radiance's shared exponent, without run lengths.
inline std::string hdrFile(const Image& image) {
    std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                       " +X " + std::to_string(image.width) + "\n";
    const float* p = image.floats();
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i, p += 3) {
        int exponent = 0;
        std::frexp(std::max({p[0], p[1], p[2]}), &exponent);
        for (int c = 0; c < 3; ++c) {
            file += static_cast<char>(static_cast<int>(std::ldexp(p[c], 8 - exponent)));
        }
        file += static_cast<char>(exponent + 128);
    }
    return file;
}

inline ImportError refusedMap(const std::filesystem::path& file,
                              const ImportOptions& options = {}) {
    try {
        loadEnvironment(file, options);
    } catch (const ImportError& error) {
        return error;
    }
    ADD_FAILURE() << file << " was read";
    return {ImportError::Reason::crashed, "was read"};
}

}  // namespace clerestory
