// The clock of clients that time a server.
#pragma once

#include <chrono>

namespace clerestory::test {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace clerestory::test
