// One request and its answer as the routes see them: plain values, no HTTP library.
#pragma once

#include "server/base/cancellation_token.h"
#include "server/base/clock.h"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clerestory {

struct Call {
    std::string method;  // HEAD arrives as GET; its body is left out later
    std::string path;    // decoded, without the query
    std::multimap<std::string, std::string> query;
    std::string body;
    std::string requestId;
    Clock::time_point arrived;                            // with its last byte
    std::function<std::string(const char* name)> header;  // empty when absent
    std::string client;                                   // its address, or what a proxy says of it
    std::shared_ptr<CancellationToken> cancellation;      // null for what HTTP itself refused
    std::string job = {};  // of one that is begun again: its id; no client can set it
};

// Takes the next piece of an answer and returns when the client can take more; false: it has left.
using Sink = std::function<bool(std::string_view piece)>;

struct Answer {
    int status = 200;
    std::string type;
    std::string body;
    std::vector<std::pair<std::string, std::string>> headers;
    std::string route;    // the table's row, for the metrics
    std::string problem;  // the code of the problem that it tells, if it does
    // Instead of a body: what is sent as it comes, chunked. Called once, on the connection's own
    // thread; whoever writes ends when the sink says so, or when the service stops. False: it broke
    // off, and the connection ends without the last chunk, so that the client knows.
    std::function<bool(const Sink&)> stream;
};

}  // namespace clerestory
