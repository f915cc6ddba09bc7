// What one client may ask of the server, before any route is asked: bytes, counts and times.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace clerestory {

// A route whose bodies may be larger than those of all others.
struct LargeBodies {
    std::string method, path;  // the path as it comes, without the query
    std::size_t bytes = 0;
};

struct FrontLimits {
    std::size_t requestLine = 2048;
    std::size_t path = 512;             // of the request line, without the query
    std::size_t headBytes = 16 * 1024;  // request line and headers
    std::size_t headers = 64;           // lines
    std::size_t bodyBytes = 64 * 1024;
    std::size_t connections = 1024;  // open at once; above it the idlest gives way
    std::chrono::milliseconds head{
        5000};  // from the first byte of a request to the last of its head
    // From there to its last byte; in which a large one makes half a megabyte of progress.
    std::chrono::milliseconds body{10000};
    std::chrono::milliseconds write{10000};  // in which a client takes kProgress of its answer
    std::chrono::milliseconds idle{15000};   // between requests
    // Of all answers together that lie here for clients to take; above it the one who writes waits.
    std::size_t unsentBytes = 64 * 1024 * 1024;
    std::vector<LargeBodies> large;
    // Of all bodies above bodyBytes together that are on their way or being answered.
    std::size_t largeBytes = 256 * 1024 * 1024;
};

}  // namespace clerestory
