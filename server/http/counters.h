// What the front counts, for the metrics. Any thread may read.
#pragma once

#include <atomic>
#include <cstdint>

namespace clerestory {

struct FrontCounters {
    std::atomic<std::uint64_t> accepted{0};
    std::atomic<std::uint64_t> open{0};        // now
    std::atomic<std::uint64_t> evicted{0};     // gave way to newer ones
    std::atomic<std::uint64_t> turnedAway{0};  // came when nobody could give way
    std::atomic<std::uint64_t> acceptErrors{0};
    std::atomic<std::uint64_t> timeouts{0};     // of requests that did not come whole
    std::atomic<std::uint64_t> stalled{0};      // answers that nobody took
    std::atomic<std::uint64_t> clientsLeft{0};  // before their answer
};

}  // namespace clerestory
