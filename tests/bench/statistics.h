// Medians and percentiles of measured milliseconds.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
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

// Of all threads of this process. On a machine that others use too it says more than the wall
// clock.
inline double processorMilliseconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

// How many threads of the whole machine wanted a core in the last minute, on average.
inline double loadAverage() {
    double load = 0.0;
    getloadavg(&load, 1);
    return load;
}

}  // namespace clerestory::bench
