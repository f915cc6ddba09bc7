// Clocks and percentiles for benchmarks.
#pragma once

#include "measures/percentile.h"

#include <chrono>
#include <cstdlib>
#include <ctime>

namespace clerestory::bench {

using clerestory::median;
using clerestory::percentile;

class Stopwatch {
public:
    double milliseconds() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
            .count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Processor time of all threads of this process. On a shared machine it is more meaningful than the
// wall clock.
inline double processorMilliseconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

// Mean number of runnable threads of the machine in the last minute.
inline double loadAverage() {
    double load = 0.0;
    getloadavg(&load, 1);
    return load;
}

}  // namespace clerestory::bench
