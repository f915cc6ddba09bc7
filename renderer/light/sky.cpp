#include "light/sky.h"

#include "light/surface_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace clerestory::light {
namespace {

constexpr std::uint32_t kEdge = 16;
// Directions of the sum along an edge of a face: between texels the map is linear.
constexpr std::uint32_t kDirections = 2 * kEdge;
// A texel has at least this share of the mean density: light reaches beyond its own texel.
constexpr double kLeastDensity = 0.05;
// Mean of the squared radiance over the square of the mean, above which a map is uneven.
constexpr double kUneven = 2.0;

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

// A point of a face at distance 1 is centre + x right + y down, with x and y in texels.
struct FaceAxes {
    explicit FaceAxes(std::uint32_t face)
        : centre(cubeTexelDirection(face, 0, 0, 1)),
          right(cubeTexelDirection(face, 1, 0, kEdge) - cubeTexelDirection(face, 0, 0, kEdge)),
          down(cubeTexelDirection(face, 0, 1, kEdge) - cubeTexelDirection(face, 0, 0, kEdge)) {}
    glm::vec3 centre, right, down;
};

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
    measureTexels();
}

void Sky::measureTexels() {
    constexpr std::uint32_t kTexels = 6 * kEdge * kEdge;
    std::vector<double> light(kTexels), angles(kTexels), cubes(kTexels);
    double angle = 0.0, sum = 0.0, squares = 0.0;
    for (std::uint32_t i = 0; i < kTexels; ++i) {
        const std::uint32_t inFace = i % (kEdge * kEdge);
        const glm::vec3 along =
            cubeTexelDirection(i / (kEdge * kEdge), inFace % kEdge, inFace / kEdge, kEdge);
        const double length = glm::length(along);
        cubes[i] = length * length * length;
        angles[i] = 4.0 / (kEdge * kEdge) / cubes[i];
        // Between centres the map is linear, so that light reaches into the next texels.
        constexpr std::uint32_t kParts = 4;
        for (std::uint32_t part = 0; part < kParts * kParts; ++part) {
            const glm::vec3 towards =
                cubeTexelDirection(i / (kEdge * kEdge), inFace % kEdge * kParts + part % kParts,
                                   inFace / kEdge * kParts + part / kParts, kEdge * kParts);
            light[i] += double{luminance(radiance(towards))} / (kParts * kParts);
        }
        angle += angles[i];
        sum += light[i] * angles[i];
        squares += light[i] * light[i] * angles[i];
    }
    const double mean = sum / angle;
    uneven_ = squares / angle > kUneven * mean * mean;
    double end = 0.0;
    for (std::uint32_t i = 0; i < kTexels; ++i) {
        light[i] += std::max(kLeastDensity * mean, 1e-30);
        end += light[i] * angles[i];
        ends_.push_back(end);
    }
    for (std::uint32_t i = 0; i < kTexels; ++i) {
        ends_[i] /= end;
        densities_.push_back(static_cast<float>(light[i] / (end * cubes[i])));
    }
    ends_.back() = 1.0;
}

glm::vec3 Sky::sample(float u, const glm::vec2& v) const {
    const auto chosen = std::upper_bound(ends_.begin(), ends_.end() - 1, double{u});
    const auto i = static_cast<std::uint32_t>(chosen - ends_.begin());
    const FaceAxes axes(i / (kEdge * kEdge));
    const std::uint32_t inFace = i % (kEdge * kEdge);
    const float x = static_cast<float>(inFace % kEdge) + v.x - 0.5f * kEdge,
                y = static_cast<float>(inFace / kEdge) + v.y - 0.5f * kEdge;
    return glm::normalize(axes.centre + x * axes.right + y * axes.down);
}

float Sky::density(const glm::vec3& along) const {
    const glm::vec3 size = glm::abs(along);
    const float longest = std::max(size.x, std::max(size.y, size.z));
    for (std::uint32_t face = 0; face < 6; ++face) {
        const FaceAxes axes(face);
        const float length = glm::dot(along, axes.centre);
        if (length < longest) continue;
        const auto coordinate = [&](const glm::vec3& axis) {
            const float texels = glm::dot(along, axis) / (length * glm::dot(axis, axis));
            return std::clamp(static_cast<int>(std::floor(texels + 0.5f * kEdge)), 0,
                              static_cast<int>(kEdge) - 1);
        };
        const auto i = static_cast<std::size_t>(coordinate(axes.down)) * kEdge +
                       static_cast<std::size_t>(coordinate(axes.right));
        return densities_[face * kEdge * kEdge + i] / (length * length * length);
    }
    return densities_.front();
}

glm::vec3 Sky::rgb(const rays::CubeMap& cube, const glm::vec3& along) {
    float rgb[3];
    cube.sample(&along.x, 0.0f, rgb);
    return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace clerestory::light
