#include "measures/error_picture.h"

#include "measures/layers.h"
#include "measures/linear_errors.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Ten even steps of matplotlib's map "magma" (van der Walt and Smith, CC0), sRGB codes.
constexpr glm::u8vec3 kSteps[] = {{0x00, 0x00, 0x04}, {0x18, 0x0f, 0x3e}, {0x45, 0x10, 0x77},
                                  {0x72, 0x1f, 0x81}, {0x9f, 0x2f, 0x7f}, {0xcd, 0x40, 0x71},
                                  {0xf1, 0x60, 0x5d}, {0xfd, 0x95, 0x67}, {0xfe, 0xc9, 0x8d},
                                  {0xfc, 0xfd, 0xbf}};
constexpr glm::u8vec3 kNotFinite{0, 255, 255};  // nowhere on the way

}  // namespace

glm::u8vec3 falseColour(double t) {
    constexpr int kLast = static_cast<int>(std::size(kSteps)) - 1;
    const double at = (t > 0.0 ? std::min(t, 1.0) : 0.0) * kLast;  // NaN is 0
    const int step = std::min(static_cast<int>(at), kLast - 1);
    const glm::dvec3 color =
        glm::mix(glm::dvec3(kSteps[step]), glm::dvec3(kSteps[step + 1]), at - step);
    return glm::u8vec3(color + 0.5);
}

Image errorPicture(const Image& actual, const Image& reference, double most) {
    const ComparedPair pair = comparedPair(actual, reference, nullptr, PixelType::float32);
    const double floor =
        std::max(kRelativeFloor * linearErrors(actual, reference).meanReference, 1e-9);
    Image picture = makeImage(actual.width, actual.height, 3, PixelType::srgb8);
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        double apart = 0.0, light = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            apart += std::abs(pair.actual[c].values[i] - pair.reference[c].values[i]) / 3.0;
            light += std::max(pair.reference[c].values[i], 0.0) / 3.0;
        }
        const glm::u8vec3 color = pair.counted[i]
                                      ? falseColour(apart / (light + floor) / std::max(most, 1e-9))
                                      : kNotFinite;
        std::copy_n(&color.x, 3, picture.bytes() + 3 * i);
    }
    return picture;
}

}  // namespace clerestory
