// Connection counts for the metrics. Any thread may read them.
#pragma once

#include <atomic>
#include <cstdint>

namespace clerestory {

struct ConnectionCounters {
    std::atomic<std::uint64_t> accepted{0};
    std::atomic<std::uint64_t> open{0};      // now
    std::atomic<std::uint64_t> evicted{0};   // closed in favour of newer ones
    std::atomic<std::uint64_t> rejected{0};  // over the limit, and none could be evicted
    std::atomic<std::uint64_t> acceptErrors{0};
    std::atomic<std::uint64_t> timeouts{0};      // requests that were not received in time
    std::atomic<std::uint64_t> stalled{0};       // responses that the client did not read
    std::atomic<std::uint64_t> disconnected{0};  // before their response
};

}  // namespace clerestory
