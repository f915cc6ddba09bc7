// The shaders' formulae as C++, shared by the tests of optics. `glsl` contains the code that the
// GPU runs.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/integer.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace clerestory::test {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace glsl {
namespace {
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
// After optics.glsl, which it needs.
#include "shaders/include/glass.glsl"
#include "shaders/include/layers.glsl"
#include "shaders/include/reflection_lookup.glsl"
#include "shaders/include/sampling.glsl"
#include "shaders/include/srgb.glsl"
#include "shaders/include/tonemap.glsl"
}  // namespace
}  // namespace glsl
#pragma GCC diagnostic pop

inline constexpr double kTruePi = std::numbers::pi;
inline constexpr float kInf = std::numeric_limits<float>::infinity();
inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

inline double radians(double degrees) {
    return degrees * kTruePi / 180.0;
}

// The density of GGX normals and the height-correlated Smith function as Walter (2007) and Heitz
// (2014) print them, in double.
inline double textbookDistribution(double nDotH, double alpha) {
    const double a2 = alpha * alpha, k = nDotH * nDotH * (a2 - 1.0) + 1.0;
    return a2 / (kTruePi * k * k);
}
inline double smithLambda(double cosine, double alpha) {
    const double tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
    return 0.5 * (std::sqrt(1.0 + alpha * alpha * tan2) - 1.0);
}
inline double textbookMaskingShadowing(double nDotL, double nDotV, double alpha) {
    return 1.0 / (1.0 + smithLambda(nDotL, alpha) + smithLambda(nDotV, alpha));
}

// Cosines as rounding spoils them, and harmless ones between.
inline const std::vector<float>& hardCosines() {
    static const std::vector<float> values{
        -1.0f, -0.5f, -1e-7f, -0.0f, 0.0f,         1e-38f, 1e-20f,         1e-7f,       1e-4f,
        0.01f, 0.3f,  0.5f,   0.9f,  1.0f - 6e-8f, 1.0f,   1.0f + 1.2e-7f, 1.0f + 4e-7f};
    return values;
}

}  // namespace clerestory::test
