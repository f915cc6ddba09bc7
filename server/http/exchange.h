// One complete request that is being handled, and responses that are written without the HTTP
// library.
#pragma once

#include "server/base/call.h"
#include "server/http/request_reader.h"

#include <span>

namespace clerestory {

struct Exchange {
    RequestHead head;
    std::string headBytes;  // up to the blank line, inclusive
    std::string body;       // moved to the handler
    std::string requestId;
    std::string client;  // for fair shares; clients that share an address count as one
    Clock::time_point arrived;
    std::shared_ptr<CancellationToken> cancellation;
    bool last = false;  // the connection is closed after the response
};

// Refers to the exchange. The path is not decoded, query and body are empty: enough for a request
// that is rejected or needs neither.
Call callOf(const Exchange& exchange);

// Headers of every response: against MIME sniffing, framing and foreign scripts.
std::span<const std::pair<const char*, const char*>> commonHeaders();

// A complete HTTP/1.1 response; without its body if `isHead`.
std::string responseBytes(const Answer& answer, const std::string& requestId, bool keepAlive,
                          bool isHead);

// The client's id if it has up to 64 letters, digits, '-', '_' and '.'; otherwise a new one.
std::string requestIdFrom(std::string_view given);

}  // namespace clerestory
