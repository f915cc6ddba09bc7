// One whole request on its way to its answer.
#pragma once

#include "server/base/call.h"
#include "server/http/request_head.h"

namespace clerestory {

struct Exchange {
    RequestHead head;
    std::string headBytes;  // with the blank line
    std::string body;       // moved on to whoever answers
    std::string requestId;
    std::string client;  // for fair shares; no two clients of one address are told apart
    Clock::time_point arrived;
    std::shared_ptr<CancellationToken> cancellation;
    bool last = false;  // the connection ends with this answer
};

// Valid as long as the exchange. The path is as it came, and there is no query and no body: enough
// to refuse, or to answer what needs neither.
Call callOf(const Exchange& exchange);

}  // namespace clerestory
