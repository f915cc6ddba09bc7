// The clock for deadlines and durations.
#pragma once

#include <chrono>

namespace clerestory {

using Clock = std::chrono::steady_clock;

inline double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace clerestory
