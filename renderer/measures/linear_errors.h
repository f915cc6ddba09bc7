// How far linear radiance is from the truth, before tone mapping: what settings are judged by.
#pragma once

#include "measures/mask.h"

namespace clerestory {

struct LinearErrors {
    std::uint64_t pixels = 0;     // counted: inside the mask and finite in both pictures
    std::uint64_t nonFinite = 0;  // inside the mask, NaN or infinite in either: left out
    double meanReference = 0.0;   // over pixels and channels, as all that follow
    double bias = 0.0;            // mean of actual - reference
    double rmse = 0.0;
    double relMse = 0.0;  // mean of (x - r)^2 / (r^2 + e^2), e = kRelativeFloor * meanReference
    double p95 = 0.0;     // of |x - r|: the least value that 95 % of the samples do not exceed
};
inline constexpr double kRelativeFloor = 0.01;

// Pictures of float32 with 3 or 4 channels, of one size; alpha is ignored. No mask: the whole
// picture. All 0 when nothing counts; always finite. Throws std::runtime_error when sizes or types
// do not fit.
LinearErrors linearErrors(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// How much of the way from an effect left out to the truth a setting has gone, on a logarithmic
// scale: 0 as bad as without the effect, 1 within the reference's noise; below 0 worse than
// without. error, errorOff and floor (the reference's noise) are of one measure, 0 or more.
// Always finite; 1 where leaving the effect out is within the noise already.
double closedGap(double error, double errorOff, double floor);

}  // namespace clerestory
