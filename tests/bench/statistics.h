// Medians and percentiles of measured milliseconds.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace clerestory::bench {

// The value below which `share` (0..1) of the measurements lie; 0 for none.
inline double percentile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    const auto last = static_cast<double>(values.size() - 1);
    return values[static_cast<std::size_t>(std::lround(share * last))];
}
inline double median(const std::vector<double>& values) {
    return percentile(values, 0.5);
}

class Stopwatch {
public:
    double milliseconds() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
            .count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace clerestory::bench
