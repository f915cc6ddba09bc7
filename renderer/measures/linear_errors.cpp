#include "measures/linear_errors.h"

#include "measures/measured_pixels.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Used for a black reference; far below the resolution of half-float frames.
constexpr double kMinFloor = 1e-9;
// Lower noise is rounding.
constexpr double kMinNoise = 1e-12;

template <class Visit>
void eachCounted(const ComparedPair& pair, Visit&& visit) {
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (!pair.counted[i]) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            visit(pair.actual[c].values[i], pair.reference[c].values[i]);
        }
    }
}

}  // namespace

LinearErrors linearErrors(const Image& actual, const Image& reference, const Mask* mask) {
    const ComparedPair pair = comparedPair(actual, reference, mask, PixelType::float32);
    LinearErrors errors{.pixels = pair.pixels, .nonFinite = pair.nonFinite};
    if (pair.pixels == 0) return errors;

    const double samples = 3.0 * double(pair.pixels);
    std::vector<double> differences;
    differences.reserve(3 * pair.pixels);
    double radiance = 0.0, difference = 0.0, squares = 0.0;
    eachCounted(pair, [&](double x, double r) {
        radiance += r;
        difference += x - r;
        squares += (x - r) * (x - r);
        differences.push_back(std::abs(x - r));
    });
    errors.meanReference = radiance / samples;
    errors.bias = difference / samples;
    errors.rmse = std::sqrt(squares / samples);

    const double floor = std::max(kRelativeFloor * std::abs(errors.meanReference), kMinFloor);
    double relative = 0.0;
    eachCounted(
        pair, [&](double x, double r) { relative += (x - r) * (x - r) / (r * r + floor * floor); });
    errors.relMse = relative / samples;

    const auto rank = static_cast<std::size_t>(std::ceil(0.95 * double(differences.size()))) - 1;
    std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(rank),
                     differences.end());
    errors.p95 = differences[rank];
    return errors;
}

double closedGap(double error, double errorOff, double floor) {
    const double noise = std::max(floor, kMinNoise);
    const auto decades = [noise](double value) {
        return std::log10(std::max(value, noise)) - std::log10(noise);
    };
    const double gap = decades(errorOff), remaining = decades(error);
    if (!(gap > 0.0)) return 1.0;
    // Bounded, because the gap may be close to 0.
    return std::clamp(1.0 - remaining / gap, -100.0, 1.0);
}

namespace {

// Ten even steps of matplotlib's map "magma" (van der Walt and Smith, CC0), sRGB codes.
constexpr glm::u8vec3 kSteps[] = {{0x00, 0x00, 0x04}, {0x18, 0x0f, 0x3e}, {0x45, 0x10, 0x77},
                                  {0x72, 0x1f, 0x81}, {0x9f, 0x2f, 0x7f}, {0xcd, 0x40, 0x71},
                                  {0xf1, 0x60, 0x5d}, {0xfd, 0x95, 0x67}, {0xfe, 0xc9, 0x8d},
                                  {0xfc, 0xfd, 0xbf}};
constexpr glm::u8vec3 kNotFinite{0, 255, 255};  // not in the colour map

}  // namespace

glm::u8vec3 falseColour(double t) {
    constexpr int kLast = static_cast<int>(std::size(kSteps)) - 1;
    const double position = (t > 0.0 ? std::min(t, 1.0) : 0.0) * kLast;  // NaN is 0
    const int step = std::min(static_cast<int>(position), kLast - 1);
    const glm::dvec3 color =
        glm::mix(glm::dvec3(kSteps[step]), glm::dvec3(kSteps[step + 1]), position - step);
    return glm::u8vec3(color + 0.5);
}

Image errorPicture(const Image& actual, const Image& reference, double maxError) {
    const ComparedPair pair = comparedPair(actual, reference, nullptr, PixelType::float32);
    const double floor =
        std::max(kRelativeFloor * linearErrors(actual, reference).meanReference, 1e-9);
    Image picture = makeImage(actual.width, actual.height, 3, PixelType::srgb8);
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        double difference = 0.0, radiance = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            difference += std::abs(pair.actual[c].values[i] - pair.reference[c].values[i]) / 3.0;
            radiance += std::max(pair.reference[c].values[i], 0.0) / 3.0;
        }
        const glm::u8vec3 color =
            pair.counted[i]
                ? falseColour(difference / (radiance + floor) / std::max(maxError, 1e-9))
                : kNotFinite;
        std::copy_n(&color.x, 3, picture.bytes() + 3 * i);
    }
    return picture;
}

}  // namespace clerestory
