// Errors of linear radiance relative to the ground truth, before tone mapping: the measures by
// which settings are judged.
#pragma once

#include "measures/measured_pixels.h"

#include <glm/glm.hpp>

namespace clerestory {

// Over all counted pixels and channels.
struct LinearErrors {
    std::uint64_t pixels = 0;     // counted: inside the mask and finite in both images
    std::uint64_t nonFinite = 0;  // inside the mask, NaN or infinite in either image: not counted
    double meanReference = 0.0;
    double bias = 0.0;  // mean of actual - reference
    double rmse = 0.0;
    double relMse = 0.0;  // mean of (x - r)^2 / (r^2 + e^2), e = kRelativeFloor * meanReference
    double p95 = 0.0;     // 95th percentile of |x - r|
};
inline constexpr double kRelativeFloor = 0.01;

// float32 images with 3 or 4 channels, of one size; alpha is ignored. Without a mask: the whole
// image. All 0 if no pixel is counted; always finite. Throws std::runtime_error if sizes or types
// do not match.
LinearErrors linearErrors(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// How much of the gap between leaving an effect out and the truth a setting closes, on a
// logarithmic scale: 0: as bad as without the effect, below 0: worse, 1: within the reference's
// noise. error, errorOff and floor (the reference's noise) are of one measure, 0 or more. Always
// finite; 1 if leaving the effect out is within the noise.
double closedGap(double error, double errorOff, double floor);

// Colour map from black through violet and orange to pale yellow, of increasing lightness. t: 0..1,
// clamped; sRGB codes.
glm::u8vec3 falseColour(double t);

// falseColour(e / maxError) per pixel, e: the mean over channels of |x - r| / (r + 1 % of the
// reference's mean). Pixels that are not finite in either image are cyan. Arguments as
// linearErrors(); maxError > 0. Returns srgb8, 3 channels.
Image errorPicture(const Image& actual, const Image& reference, double maxError = 1.0);

}  // namespace clerestory
