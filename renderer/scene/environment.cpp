// Cube map geometry: texel directions, solid angles, spherical harmonics, resampling of images.
#include "scene/environment.h"

#include "scene/hash.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr float kMaxTexel = 65504.0f;
constexpr std::uint32_t kMaxFaceSize =
    512;  // more detail is not visible in 8 bits or in rough lobes

// NaN, infinities and negative values become 0: comparisons with NaN are false.
float clampedRadiance(float x) {
    return x > 0.0f ? (std::isinf(x) ? 0.0f : std::min(x, kMaxTexel)) : 0.0f;
}

// An equirectangular image: x is the azimuth, y runs from +Y to -Y.
struct Panorama {
    std::uint32_t width = 0, height = 0;
    std::vector<glm::vec3> texels;

    const glm::vec3& at(std::uint32_t x, std::uint32_t y) const {
        return texels[std::size_t(y) * width + x];
    }
};

Panorama halved(const Panorama& from) {
    Panorama to{.width = from.width / 2, .height = from.height / 2};
    to.texels.reserve(std::size_t(to.width) * to.height);
    for (std::uint32_t y = 0; y < to.height; ++y) {
        for (std::uint32_t x = 0; x < to.width; ++x) {
            to.texels.push_back(0.25f *
                                (from.at(2 * x, 2 * y) + from.at(2 * x + 1, 2 * y) +
                                 from.at(2 * x, 2 * y + 1) + from.at(2 * x + 1, 2 * y + 1)));
        }
    }
    return to;
}

// Bilinear; repeats in x, clamps at the poles.
glm::vec3 lookUp(const Panorama& map, const glm::vec3& direction) {
    constexpr float kTurn = 2.0f * std::numbers::pi_v<float>;
    const float length = glm::length(direction);  // at least 1, see cubeTexelDirection
    const float turn = 0.5f + std::atan2(direction.x, -direction.z) / kTurn;
    const float fall = std::acos(std::clamp(direction.y / length, -1.0f, 1.0f)) * 2.0f / kTurn;
    const float x = turn * float(map.width) - 0.5f;
    const float y = std::clamp(fall * float(map.height) - 0.5f, 0.0f, float(map.height - 1));
    const float left = std::floor(x), top = std::floor(y);
    const auto column = [&](float c) {
        return (static_cast<std::uint32_t>(c + float(map.width))) % map.width;
    };
    const std::uint32_t x0 = column(left), x1 = column(left + 1.0f);
    const auto y0 = static_cast<std::uint32_t>(top);
    const std::uint32_t y1 = std::min(y0 + 1, map.height - 1);
    return glm::mix(glm::mix(map.at(x0, y0), map.at(x1, y0), x - left),
                    glm::mix(map.at(x0, y1), map.at(x1, y1), x - left), y - top);
}

// The greatest power of two that is at most x; x is at least 1.
std::uint32_t powerOfTwoWithin(std::uint32_t x) {
    std::uint32_t power = 1;
    while (power <= x / 2) power *= 2;
    return power;
}

// OpenGL's table of faces; s and t in -1..1 from the texture's left and first row.
glm::vec3 cubeDirection(std::uint32_t face, float s, float t) {
    switch (face) {
        case 0:
            return {1.0f, -t, -s};
        case 1:
            return {-1.0f, -t, s};
        case 2:
            return {s, 1.0f, t};
        case 3:
            return {s, -1.0f, -t};
        case 4:
            return {s, -t, 1.0f};
        default:
            return {-s, -t, -1.0f};
    }
}

}  // namespace

glm::vec3 cubeTexelDirection(std::uint32_t face, std::uint32_t x, std::uint32_t y,
                             std::uint32_t faceSize) {
    const float scale = 2.0f / float(faceSize);
    return cubeDirection(face, (float(x) + 0.5f) * scale - 1.0f, (float(y) + 0.5f) * scale - 1.0f);
}

EnvironmentMap environmentFromEquirectangular(std::string name,
                                              const std::vector<glm::vec3>& texels,
                                              std::uint32_t width, std::uint32_t height) {
    if (width == 0 || height == 0 || texels.size() != std::size_t(width) * height) {
        throw std::runtime_error("environment " + name + ": the image is empty or incomplete");
    }
    Panorama panorama{.width = width, .height = height, .texels = texels};
    for (glm::vec3& texel : panorama.texels) {
        texel = {clampedRadiance(texel.x), clampedRadiance(texel.y), clampedRadiance(texel.z)};
    }
    // A face covers a quarter of the azimuth.
    EnvironmentMap map{.name = name, .title = name};
    map.faceSize = std::min(powerOfTwoWithin(std::max(width / 4, 4u)), kMaxFaceSize);
    while (panorama.width >= 8 * map.faceSize && panorama.height >= 2) panorama = halved(panorama);

    // Four bilinear samples a texel: each covers at most one texel of the panorama.
    const float scale = 2.0f / float(map.faceSize);
    map.texels.reserve(6 * std::size_t(map.faceSize) * map.faceSize);
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x) {
                glm::vec3 sum(0.0f);
                for (const float dy : {0.25f, 0.75f}) {
                    for (const float dx : {0.25f, 0.75f}) {
                        sum += lookUp(panorama, cubeDirection(face, (float(x) + dx) * scale - 1.0f,
                                                              (float(y) + dy) * scale - 1.0f));
                    }
                }
                // Interpolation may round above the largest input.
                map.texels.push_back(glm::min(0.25f * sum, glm::vec3(kMaxTexel)));
            }
        }
    }
    updateContentHash(map);
    return map;
}

std::array<glm::vec3, 9> diffuseHarmonics(const EnvironmentMap& map) {
    std::array<glm::dvec3, 9> sums{};
    double sphere = 0.0;
    std::size_t texel = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            // Summed by rows for precision and speed.
            std::array<glm::dvec3, 9> row{};
            for (std::uint32_t x = 0; x < map.faceSize; ++x) {
                const glm::dvec3 d(cubeTexelDirection(face, x, y, map.faceSize));
                const double inverse = 1.0 / std::sqrt(glm::dot(d, d));
                const glm::dvec3 n = d * inverse;
                // The solid angle of a texel is proportional to 1 / distance^3.
                const double weight = inverse * inverse * inverse;
                const glm::dvec3 light = weight * glm::dvec3(map.texels[texel++]);
                const std::array<double, 9> basis{1.0,
                                                  n.y,
                                                  n.z,
                                                  n.x,
                                                  n.x * n.y,
                                                  n.y * n.z,
                                                  3.0 * n.z * n.z - 1.0,
                                                  n.x * n.z,
                                                  n.x * n.x - n.y * n.y};
                sphere += weight;
                for (std::size_t i = 0; i < 9; ++i) row[i] += basis[i] * light;
            }
            for (std::size_t i = 0; i < 9; ++i) sums[i] += row[i];
        }
    }
    // The squared constants of Y times 4 pi, and the factor of the cosine lobe for each band over
    // pi.
    constexpr std::array<double, 9> kSquares{1, 3, 3, 3, 15, 15, 5.0 / 4.0, 15, 15.0 / 4.0};
    constexpr std::array<double, 3> kCosine{1.0, 2.0 / 3.0, 1.0 / 4.0};
    std::array<glm::vec3, 9> result{};
    for (std::size_t i = 0; i < 9 && sphere > 0.0; ++i) {
        const std::size_t band = i == 0 ? 0 : i < 4 ? 1 : 2;
        result[i] = glm::vec3(sums[i] * (kSquares[i] * kCosine[band] / sphere));
    }
    return result;
}

void updateContentHash(EnvironmentMap& map) {
    std::uint64_t hash = hashOfBytes(std::as_bytes(std::span(map.texels)), map.faceSize);
    if (map.sun) {
        const std::array<glm::vec3, 2> sun{map.sun->toSun, map.sun->irradiance};
        hash = hashOfBytes(std::as_bytes(std::span(sun)), hash);
    }
    map.contentHash = hash;
}

}  // namespace clerestory
