// The GGX samples use the formulae of the shaders.
#include "passes/cube_samples.h"

#include "passes/blocks.h"

#include <glm/gtc/integer.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
// Requires optics.glsl.
#include "shaders/include/sampling.glsl"
#pragma GCC diagnostic pop

}  // namespace

std::vector<glm::vec4> environmentSamples(float roughness, std::uint32_t count,
                                          float sourceFaceSize, float targetFaceSize) {
    // The target cannot represent finer levels.
    const float minLevel = std::log2(std::max(1.0f, sourceFaceSize / targetFaceSize));
    if (!(roughness > 0.0f)) return {{0.0f, 0.0f, 1.0f, minLevel}};
    const float alpha = roughness * roughness;
    const std::uint32_t n = std::clamp<std::uint32_t>(count, 1, PREFILTER_SAMPLES);
    std::vector<glm::vec4> samples;
    for (std::uint32_t i = 0; i < n; ++i) {
        const glm::vec3 h = ggxHalfVector(hammersley(i, n), alpha);
        // The direction to the eye, +Z, reflected at h.
        const glm::vec3 toLight(2.0f * h.z * h.x, 2.0f * h.z * h.y, 2.0f * h.z * h.z - 1.0f);
        if (!(toLight.z > 0.0f)) continue;
        const float pdf = 0.25f * ggxDistribution(h.z, h.x * h.x + h.y * h.y, alpha);
        const float level = sampleLod(pdf, static_cast<float>(n), sourceFaceSize);
        samples.emplace_back(toLight, std::max(level, minLevel));
    }
    if (samples.empty()) samples.emplace_back(0.0f, 0.0f, 1.0f, minLevel);
    return samples;
}

std::vector<glm::vec4> blurRotations(const MapBlur& blur, std::uint32_t faceSize) {
    // At the edge of a face a rotation by a central texel spans two texels: half steps miss none.
    constexpr int kStepsPerTexel = 2;
    // Bilinear reads at half steps blur too: by 1/4 square texel at every second step.
    constexpr double kFilterVariance = 0.125;
    const double variance = std::max(blur.stdev * blur.stdev - kFilterVariance, 1e-4);
    const double step = 2.0 / (double{kStepsPerTexel} * faceSize);  // radians; a face is 2 wide
    const int last = kStepsPerTexel * static_cast<int>(blur.size);
    std::vector<glm::dvec3> rotations;
    double sum = 0.0;
    for (int i = -last; i <= last; ++i) {
        const double texels = static_cast<double>(i) / kStepsPerTexel;
        const double weight = std::exp(-0.5 * texels * texels / variance);
        rotations.emplace_back(std::cos(i * step), std::sin(i * step), weight);
        sum += weight;
    }
    std::vector<glm::vec4> result;
    for (const glm::dvec3& t : rotations) result.emplace_back(t.x, t.y, t.z / sum, 0.0);
    return result;
}

}  // namespace clerestory
