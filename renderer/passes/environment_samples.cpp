// GGX importance samples with the formulae that the shaders use.
#include "passes/environment_samples.h"

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
// After optics.glsl, which it needs.
#include "shaders/include/sampling.glsl"
#pragma GCC diagnostic pop

}  // namespace

std::vector<glm::vec4> environmentSamples(float roughness, std::uint32_t count,
                                          float sourceFaceSize, float targetFaceSize) {
    // No sharper than the target can hold.
    const float leastLevel = std::log2(std::max(1.0f, sourceFaceSize / targetFaceSize));
    if (!(roughness > 0.0f)) return {{0.0f, 0.0f, 1.0f, leastLevel}};
    const float alpha = roughness * roughness;
    const std::uint32_t n = std::clamp<std::uint32_t>(count, 1, PREFILTER_SAMPLES);
    std::vector<glm::vec4> samples;
    for (std::uint32_t i = 0; i < n; ++i) {
        const glm::vec3 h = ggxHalfVector(hammersley(i, n), alpha);
        // The eye along +Z, mirrored at h.
        const glm::vec3 toLight(2.0f * h.z * h.x, 2.0f * h.z * h.y, 2.0f * h.z * h.z - 1.0f);
        if (!(toLight.z > 0.0f)) continue;
        const float pdf = 0.25f * ggxDistribution(h.z, h.x * h.x + h.y * h.y, alpha);
        const float level = sampleLod(pdf, static_cast<float>(n), sourceFaceSize);
        samples.emplace_back(toLight, std::max(level, leastLevel));
    }
    if (samples.empty()) samples.emplace_back(0.0f, 0.0f, 1.0f, leastLevel);
    return samples;
}

}  // namespace clerestory
