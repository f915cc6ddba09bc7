#include "passes/blur_turns.h"

#include <algorithm>
#include <cmath>

namespace clerestory {

std::vector<glm::vec4> blurTurns(const MapBlur& blur, std::uint32_t faceSize) {
    // At a face's edge a turn by a central texel passes over two: half steps miss none.
    constexpr int kStepsPerTexel = 2;
    // Blended reads at half steps spread by themselves: 1/4 square texel at every other one.
    constexpr double kOwnVariance = 0.125;
    const double variance = std::max(blur.stdev * blur.stdev - kOwnVariance, 1e-4);
    const double step = 2.0 / (double{kStepsPerTexel} * faceSize);  // radians; a face is 2 wide
    const int last = kStepsPerTexel * static_cast<int>(blur.size);
    std::vector<glm::dvec3> turns;
    double sum = 0.0;
    for (int i = -last; i <= last; ++i) {
        const double texels = static_cast<double>(i) / kStepsPerTexel;
        const double weight = std::exp(-0.5 * texels * texels / variance);
        turns.emplace_back(std::cos(i * step), std::sin(i * step), weight);
        sum += weight;
    }
    std::vector<glm::vec4> result;
    for (const glm::dvec3& t : turns) result.emplace_back(t.x, t.y, t.z / sum, 0.0);
    return result;
}

}  // namespace clerestory
