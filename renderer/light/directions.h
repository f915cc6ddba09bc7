// Directions and sequences of points for rays from a place.
#pragma once

#include <glm/glm.hpp>

#include <cmath>
#include <cstdint>

namespace clerestory::light {

inline constexpr float kGoldenAngle = 2.39996323f;

// Two axes across a unit vector (Duff et al. 2017).
inline void axesAbout(const glm::vec3& n, glm::vec3& x, glm::vec3& y) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    x = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
}

inline std::uint32_t hashed(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

inline float fraction(float x) {
    return x - std::floor(x);
}

// Point `i` of a sequence with even gaps (Roberts 2018), moved by a hash.
inline glm::vec2 pointOfSequence(std::uint32_t i, std::uint32_t seed) {
    const std::uint32_t h = hashed(seed);
    const double x = 0.7548776662466927 * i, y = 0.5698402909980532 * i;
    return {
        fraction(static_cast<float>(x - std::floor(x)) +
                 static_cast<float>(h & 0xffffu) / 65536.0f),
        fraction(static_cast<float>(y - std::floor(y)) + static_cast<float>(h >> 16) / 65536.0f)};
}

}  // namespace clerestory::light
