// What rays from one side of a place have brought, round by round, and the bounces that follow.
#pragma once

#include "light/surface_light.h"

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::light {

// Sums over rays on one side of a surface.
struct RaySums {
    float count = 0.0f;           // rays
    glm::vec3 open{0.0f};         // radiance of the environment that arrives
    glm::vec3 hidden{0.0f};       // and that does not
    glm::vec3 wholeSky{0.0f};     // irradiance over pi if nothing hid it
    glm::vec3 emittersMet{0.0f};  // of emitters that rays met, weighted, and of lights in mirrors
    glm::vec3 openFlux{0.0f};     // luminance of both times direction over cosine
    glm::vec3 directions{0.0f};
    float visible = 0.0f;     // share of the environment
    glm::vec3 towards{0.0f};  // that times the direction
    float behind = 0.0f;      // rays that began behind a surface
    float covered = 0.0f;     // and that met an emitter close by
    // For specular lobes, as EmittersAtVertex: of emitters that rays met and of lights in mirrors,
    // with their flux, and of emitters that rays were sent to.
    glm::vec3 metLight{0.0f}, metFlux{0.0f}, emitterLight{0.0f};
    // Light from other surfaces: later rounds know more of it, so that earlier ones count less.
    float bounceCount = 0.0f;
    glm::vec3 bounces{0.0f};
    glm::vec3 bounceFlux{0.0f};
    // Rays towards emitters: irradiance over pi, weighted.
    float emitterCount = 0.0f;
    glm::vec3 emitters{0.0f};
    glm::vec3 emitterFlux{0.0f};
    float emitterShare = 0.0f;  // of the directions, by cosine, that emitters fill

    void forgetBounces(float factor);
    // Irradiance over pi of the environment.
    glm::vec3 fromSky() const;
    // From the environment, emitters and lights in mirrors, and from other surfaces.
    glm::vec3 direct() const;
    glm::vec3 bounced() const;
    // The share of the environment by direction, as LightAtVertex::visible.
    glm::vec4 visibleFrom(const glm::vec3& normal) const;
    EmittersAtVertex ofEmitters() const;
    // bounceScale: see BounceSeries.
    glm::vec3 flux(const glm::vec3& bounceScale) const;
};

// Rounds before this one count for less in the bounces that follow them.
float keptOfBounces(std::uint32_t round);

// Scales the bounces to the sum of all, of which n rounds know the first n - 1. The light S that
// surfaces have from each other and the light D that they have from elsewhere fulfil S = T (D + S).
// In the mean over all places T is the factor by which a round's bounces fall behind what the round
// before has sent; then S = t D / (1 - t), which is exact once S has the shape of the limit.
class BounceSeries {
public:
    // Means over all places after a round: of light from elsewhere, and of RaySums::bounced().
    void endRound(std::uint32_t round, const glm::dvec3& direct, const glm::dvec3& bounced);
    const glm::vec3& scale() const { return scale_; }

private:
    glm::vec3 scale_{1.0f};
    glm::dvec3 sent_{0.0}, bounced_{0.0};
    double weight_ = 0.0;  // of the rounds in `bounced_`, in rounds
};

}  // namespace clerestory::light
