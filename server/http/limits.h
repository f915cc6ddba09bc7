// Limits of the HTTP server that apply before routing: bytes, counts and times; and its counts of
// connections for the metrics.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clerestory {

// A route that allows a larger body than the others.
struct LargeBodies {
    std::string method, path;  // the path is not decoded
    std::size_t bytes = 0;
};

// Up to kUncountedBytes a response counts to no limit, up to kSmallBytes it is a small one.
inline constexpr std::size_t kUncountedBytes = 64 * 1024;
inline constexpr std::size_t kSmallBytes = 1024 * 1024;

struct HttpLimits {
    std::size_t requestLine = 2048;
    std::size_t path = 512;             // of the request line, without the query
    std::size_t headBytes = 16 * 1024;  // request line and headers
    std::size_t headers = 64;           // lines
    std::size_t bodyBytes = 64 * 1024;
    std::size_t connections = 1024;  // open at once; above it the most idle one is closed
    // From the first byte of a request to the end of its headers.
    std::chrono::milliseconds head{5000};
    // To receive a body, or half a megabyte of a large one.
    std::chrono::milliseconds body{10000};
    // For a client to read 4 KiB of a response, and a thirtieth of a large one.
    std::chrono::milliseconds write{10000};
    std::chrono::milliseconds idle{15000};  // between requests
    // Of responses that are not read yet, of all clients together; see server/base/holdings.h for
    // the share of one. Small ones have a limit of their own, so that large ones that are read
    // slowly do not refuse them. Those of at most kUncountedBytes are bounded by the connections.
    std::size_t unsentBytes = 128 * 1024 * 1024;
    std::size_t smallUnsentBytes = 64 * 1024 * 1024;
    std::size_t streams = 32;  // live streams and sequences, of all clients together
    std::size_t views = 128;   // live views, of all clients together
    std::size_t waits = 8;     // frames that wait for light, uploads that load; of all clients
    std::vector<LargeBodies> large;
    // Of all bodies above bodyBytes together that are being received or handled.
    std::size_t largeBytes = 256 * 1024 * 1024;
};

// Any thread may read them.
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
