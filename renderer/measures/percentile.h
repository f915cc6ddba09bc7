// Percentiles of measurements, by nearest rank.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace clerestory {

// The measurement that the fraction `share` (0..1) of the others does not exceed; 0 if there are no
// measurements.
inline double percentile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    const auto last = static_cast<double>(values.size() - 1);
    const auto rank = static_cast<std::ptrdiff_t>(std::lround(share * last));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}
inline double median(const std::vector<double>& values) {
    return percentile(values, 0.5);
}

}  // namespace clerestory
