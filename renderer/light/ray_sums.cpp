#include "light/ray_sums.h"

#include <algorithm>

namespace clerestory::light {

namespace {
constexpr double kMaxScale = 8.0;  // of bounces
}

void RaySums::forgetBounces(float factor) {
    bounceCount *= factor;
    bounces *= factor;
    bounceFlux *= factor;
}

// If most of the environment is visible, the hidden part has the smaller variance: a surface in the
// open has no noise under a map with bright windows.
glm::vec3 RaySums::fromSky() const {
    const float perRay = 1.0f / std::max(count, 1.0f);
    const glm::vec3 less = glm::max(wholeSky - hidden * perRay, 0.0f);
    return glm::mix(open * perRay, less, std::clamp(visible * perRay, 0.0f, 1.0f));
}

glm::vec3 RaySums::direct() const {
    return fromSky() + emittersMet / std::max(count, 1.0f) +
           emitters / std::max(emitterCount, 1.0f);
}

glm::vec3 RaySums::bounced() const {
    return bounces / std::max(bounceCount, 1e-6f);
}

// Least squares over directions with the density of cosines. The variance of the direction's part
// along the normal is 1/18, of those across it 1/4.
glm::vec4 RaySums::visibleFrom(const glm::vec3& normal) const {
    const float rays = std::max(count, 1.0f), mean = visible / rays;
    const glm::vec3 direction = directions / rays;
    const glm::vec3 covariance = towards / rays - mean * direction;
    const float upward = glm::dot(covariance, normal);
    const glm::vec3 slope = 4.0f * (covariance - upward * normal) + 18.0f * upward * normal;
    return {slope, mean - glm::dot(slope, direction)};
}

EmittersAtVertex RaySums::ofEmitters() const {
    const float perRay = 1.0f / std::max(count, 1.0f);
    const float perSent = 1.0f / std::max(emitterCount, 1.0f);
    return {.light = metLight * perRay + emitterLight * perSent,
            .flux = metFlux * perRay + emitterFlux * perSent};
}

glm::vec3 RaySums::flux(const glm::vec3& bounceScale) const {
    return openFlux / std::max(count, 1.0f) +
           bounceScale * bounceFlux / std::max(bounceCount, 1e-6f) +
           emitterFlux / std::max(emitterCount, 1.0f);
}

float keptOfBounces(std::uint32_t round) {
    return round <= 3 ? 0.25f : 1.0f;
}

void BounceSeries::endRound(std::uint32_t round, const glm::dvec3& direct,
                            const glm::dvec3& bounced) {
    const double kept = keptOfBounces(round) * weight_;
    for (int c = 0; c < 3; ++c) {
        const double ofRound = bounced[c] * (kept + 1.0) - bounced_[c] * kept;
        const double factor = sent_[c] > 0.0 ? std::clamp(ofRound / sent_[c], 0.0, 0.98) : 0.0;
        const double limit = factor * direct[c] / (1.0 - factor);
        scale_[c] = bounced[c] > 0.0 && limit > bounced[c]
                        ? static_cast<float>(std::min(limit / bounced[c], kMaxScale))
                        : 1.0f;
        sent_[c] = direct[c] + double{scale_[c]} * bounced[c];
    }
    weight_ = kept + 1.0;
    bounced_ = bounced;
}

}  // namespace clerestory::light
