#include "light/sky.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clerestory::light {
namespace {

constexpr std::uint32_t kEdge = 16;
// Directions of the sum along an edge of a face: between texels the map is linear.
constexpr std::uint32_t kDirections = 2 * kEdge;

rays::CubeMap reducedMap(const EnvironmentMap& map) {
    const std::uint32_t edge = std::min(kEdge, std::max(map.faceSize, 1u));
    rays::CubeMap cube(edge, 1);
    std::vector<float> texels(std::size_t{4} * edge * edge);
    for (std::uint32_t face = 0; face < 6; ++face) {
        std::fill(texels.begin(), texels.end(), 0.0f);
        std::vector<float> weights(std::size_t{edge} * edge, 0.0f);
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x) {
                const std::size_t to = std::size_t{y * edge / map.faceSize} * edge +
                                       std::size_t{x * edge / map.faceSize};
                const glm::vec3& c =
                    map.texels[(std::size_t{face} * map.faceSize + y) * map.faceSize + x];
                for (int k = 0; k < 3; ++k) texels[4 * to + static_cast<std::size_t>(k)] += c[k];
                weights[to] += 1.0f;
            }
        }
        for (std::size_t i = 0; i < weights.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) texels[4 * i + k] /= std::max(weights[i], 1.0f);
        }
        cube.setFace(0, face, texels);
    }
    cube.joinEdges();
    return cube;
}

}  // namespace

Sky::Sky(const EnvironmentMap& map) : map_(reducedMap(map)), irradiance_(kEdge, 1) {
    struct Part {
        glm::vec3 towards;  // unit, times the solid angle
        glm::vec3 radiance;
    };
    std::vector<Part> parts;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < kDirections; ++y) {
            for (std::uint32_t x = 0; x < kDirections; ++x) {
                const glm::vec3 along = cubeTexelDirection(face, x, y, kDirections);
                const float length = glm::length(along);  // of a vector to a face at distance 1
                parts.push_back({along / (length * length * length * length), radiance(along)});
            }
        }
    }
    std::vector<float> texels(std::size_t{4} * kEdge * kEdge);
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t i = 0; i < kEdge * kEdge; ++i) {
            const glm::vec3 normal = cubeTexelDirection(face, i % kEdge, i / kEdge, kEdge);
            glm::vec3 sum(0.0f);
            float cosines = 0.0f;
            for (const Part& part : parts) {
                const float cosine = std::max(glm::dot(normal, part.towards), 0.0f);
                sum += cosine * part.radiance;
                cosines += cosine;
            }
            for (int k = 0; k < 3; ++k) {
                texels[4 * i + static_cast<std::size_t>(k)] = sum[k] / cosines;
            }
        }
        irradiance_.setFace(0, face, texels);
    }
    irradiance_.joinEdges();
}

glm::vec3 Sky::rgb(const rays::CubeMap& cube, const glm::vec3& along) {
    float rgb[3];
    cube.sample(&along.x, 0.0f, rgb);
    return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace clerestory::light
