#include "measures/displayed.h"

#include <glm/glm.hpp>
#include <glm/gtc/integer.hpp>

#include <algorithm>
#include <stdexcept>

namespace clerestory {
namespace {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace glsl {
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
// Requires optics.glsl.
#include "shaders/include/tonemap.glsl"
}  // namespace glsl
#pragma GCC diagnostic pop

glm::vec3 toneMapped(glm::vec3 radiance, ToneMap curve) {
    switch (curve) {
        case ToneMap::neutral:
            return glsl::toneMapNeutral(radiance);
        case ToneMap::aces:
            return glsl::toneMapAces(radiance);
        case ToneMap::linear:
            break;
    }
    return glsl::toneMapLinear(radiance);
}

}  // namespace

Image displayed(const Image& linear, ToneMap curve, float exposureFactor) {
    if (linear.type != PixelType::float32 || linear.channels < 3) {
        throw std::runtime_error("tone mapping requires float32 with 3 or 4 channels");
    }
    Image result = makeImage(linear.width, linear.height, 3, PixelType::float32);
    const std::size_t pixels = std::size_t(linear.width) * linear.height;
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* from = linear.floats() + i * linear.channels;
        const glm::vec3 radiance = glm::vec3(from[0], from[1], from[2]) * exposureFactor;
        const glm::vec3 code = glsl::srgbFromLinear(toneMapped(radiance, curve));
        std::copy_n(&code.x, 3, result.floats() + 3 * i);
    }
    return result;
}

Image quantised(const Image& image) {
    if (image.type != PixelType::float32) {
        throw std::runtime_error("rounding to 8 bits requires a float image");
    }
    Image result = makeImage(image.width, image.height, image.channels, PixelType::srgb8);
    for (std::size_t i = 0; i < result.data.size(); ++i) {
        const float x = image.floats()[i];
        const float code = x > 0.0f ? std::min(x, 1.0f) : 0.0f;  // NaN becomes 0
        result.bytes()[i] = static_cast<std::uint8_t>(255.0f * code + 0.5f);
    }
    return result;
}

}  // namespace clerestory
