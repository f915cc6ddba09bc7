// Nine spherical harmonics of a map: its irradiance, and how well they represent wide lobes.
#include "scene/environment.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace glsl {
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
}  // namespace glsl
#pragma GCC diagnostic pop

// The map at a size at which sums over all pairs of directions are cheap.
constexpr std::uint32_t kCoarseSize = 16;

EnvironmentMap coarse(const EnvironmentMap& map) {
    EnvironmentMap result;
    result.faceSize = std::min(map.faceSize, kCoarseSize);
    result.texels.resize(std::size_t{6} * result.faceSize * result.faceSize);
    std::vector<float> counts(result.texels.size());
    std::size_t texel = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            const std::size_t row =
                (std::size_t{face} * result.faceSize + y * result.faceSize / map.faceSize) *
                result.faceSize;
            for (std::uint32_t x = 0; x < map.faceSize; ++x) {
                const std::size_t cell = row + x * result.faceSize / map.faceSize;
                result.texels[cell] += map.texels[texel++];
                counts[cell] += 1.0f;
            }
        }
    }
    for (std::size_t i = 0; i < counts.size(); ++i) result.texels[i] /= counts[i];
    return result;
}

// What a lobe of GGX seen from straight above weighs light by: the density of its half vectors
// times the cosine, as prefiltering does. cosine: against the lobe's axis.
double lobe(double cosine, double roughness) {
    if (cosine <= 0.0) return 0.0;
    const double a2 = std::pow(roughness, 4.0);
    const double q = 0.5 * (1.0 + cosine) * (a2 - 1.0) + 1.0;
    return a2 / (q * q) * cosine;
}

struct CoarseTexel {
    glm::dvec3 towards;
    double solidAngle;  // relative
    double luminance;
};

double luminance(const glm::vec3& color) {
    return static_cast<double>(glsl::luminance(color));
}

glm::vec3 harmonicsAlong(const std::array<glm::vec3, 9>& c, const glm::vec3& n,
                         const glm::vec2& bands) {
    const float linear = bands.x, quadratic = bands.y;
    return glsl::harmonics9(n, c[0], linear * c[1], linear * c[2], linear * c[3], quadratic * c[4],
                            quadratic * c[5], quadratic * c[6], quadratic * c[7], quadratic * c[8]);
}

}  // namespace

glm::vec3 harmonicsAlong(const std::array<glm::vec3, 9>& harmonics, const glm::vec3& normal) {
    return harmonicsAlong(harmonics, normal, glm::vec2(1.0f));
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

std::array<float, 4> harmonicErrors(const EnvironmentMap& map) {
    const EnvironmentMap small = coarse(map);
    const std::array<glm::vec3, 9> harmonics = diffuseHarmonics(small);
    std::vector<CoarseTexel> texels;
    double sum = 0.0, sphere = 0.0;
    std::size_t texel = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < small.faceSize; ++y) {
            for (std::uint32_t x = 0; x < small.faceSize; ++x) {
                const glm::dvec3 d(cubeTexelDirection(face, x, y, small.faceSize));
                const double length = glm::length(d);
                texels.push_back({d / length, 1.0 / (length * length * length),
                                  luminance(small.texels[texel++])});
                sum += texels.back().solidAngle * texels.back().luminance;
                sphere += texels.back().solidAngle;
            }
        }
    }
    std::array<float, 4> errors{};
    if (!(sum > 0.0)) return errors;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const float roughness = kHarmonicRoughness[i];
        double squares = 0.0;
        int directions = 0;
        for (int z = -1; z <= 1; ++z) {
            for (int y = -1; y <= 1; ++y) {
                for (int x = -1; x <= 1; ++x) {
                    if (x == 0 && y == 0 && z == 0) continue;
                    const glm::dvec3 axis = glm::normalize(glm::dvec3(x, y, z));
                    double gathered = 0.0, weights = 0.0;
                    for (const CoarseTexel& from : texels) {
                        const double weight =
                            from.solidAngle * lobe(glm::dot(axis, from.towards), roughness);
                        gathered += weight * from.luminance;
                        weights += weight;
                    }
                    const glm::vec3 approximate =
                        harmonicsAlong(harmonics, glm::vec3(axis), glsl::lobeBands(roughness));
                    const double error = luminance(approximate) - gathered / weights;
                    squares += error * error;
                    ++directions;
                }
            }
        }
        errors[i] = static_cast<float>(std::sqrt(squares / directions) / (sum / sphere));
    }
    return errors;
}

float harmonicError(const EnvironmentMap& map, float roughness) {
    const auto& at = kHarmonicRoughness;
    if (!(roughness >= at.front())) return std::numeric_limits<float>::infinity();
    std::size_t i = 0;
    while (i + 2 < at.size() && roughness > at[i + 1]) ++i;
    const float share = std::min((roughness - at[i]) / (at[i + 1] - at[i]), 1.0f);
    return glm::mix(map.harmonicErrors[i], map.harmonicErrors[i + 1], share);
}

}  // namespace clerestory
