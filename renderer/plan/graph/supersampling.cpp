#include "plan/graph/supersampling.h"

#include <glm/gtc/constants.hpp>

#include <cmath>

namespace clerestory {

glm::dvec2 samplePlace(std::uint32_t sample) {
    if (sample == 0) return glm::dvec2(0.0);
    if (sample < 4) {
        constexpr double kRadius = 0.42, kFirst = 0.244;
        const double angle = kFirst + double(sample - 1) * glm::two_pi<double>() / 3.0;
        return kRadius * glm::dvec2(std::cos(angle), std::sin(angle));
    }
    constexpr double kPlastic = 1.32471795724474602596;  // the real root of x^3 = x + 1
    const glm::dvec2 step(1.0 / kPlastic, 1.0 / (kPlastic * kPlastic));
    const std::uint32_t pair = (sample - 4) / 2;
    const glm::dvec2 place = glm::fract(glm::dvec2(0.3224, 0.2907) + double(pair) * step) - 0.5;
    return sample % 2 == 0 ? place : -place;
}

}  // namespace clerestory
