#include "measures/linear_errors.h"

#include "measures/layers.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// A black reference has no scale of its own; this is far below what a frame of half floats shows.
constexpr double kMinFloor = 1e-9;
// Noise below this is rounding.
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
    std::vector<double> apart;
    apart.reserve(3 * pair.pixels);
    double light = 0.0, difference = 0.0, squares = 0.0;
    eachCounted(pair, [&](double x, double r) {
        light += r;
        difference += x - r;
        squares += (x - r) * (x - r);
        apart.push_back(std::abs(x - r));
    });
    errors.meanReference = light / samples;
    errors.bias = difference / samples;
    errors.rmse = std::sqrt(squares / samples);

    const double floor = std::max(kRelativeFloor * std::abs(errors.meanReference), kMinFloor);
    double relative = 0.0;
    eachCounted(
        pair, [&](double x, double r) { relative += (x - r) * (x - r) / (r * r + floor * floor); });
    errors.relMse = relative / samples;

    const auto place = static_cast<std::size_t>(std::ceil(0.95 * double(apart.size()))) - 1;
    std::nth_element(apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(place),
                     apart.end());
    errors.p95 = apart[place];
    return errors;
}

double closedGap(double error, double errorOff, double floor) {
    const double noise = std::max(floor, kMinNoise);
    const auto decades = [noise](double value) {
        return std::log10(std::max(value, noise)) - std::log10(noise);
    };
    const double whole = decades(errorOff), left = decades(error);
    if (!(whole > 0.0)) return 1.0;
    // An error just above the noise would be divided by next to nothing.
    return std::clamp(1.0 - left / whole, -100.0, 1.0);
}

}  // namespace clerestory
