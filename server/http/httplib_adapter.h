// Passes a complete request in memory to cpp-httplib, which decodes path and query, calls the
// handler, and writes headers and compressed bodies. The library never sees a socket.
#pragma once

#include "server/http/exchange.h"

namespace clerestory {

using Responder = std::function<Answer(const Call&)>;
// Makes the response to a request that is rejected before routing; its call has no body.
using Refuser = std::function<Answer(const Call&, const Problem&)>;

class HttplibAdapter {
public:
    // Both are called from any thread and must not throw.
    HttplibAdapter(const HttpLimits& limits, Responder responder, Refuser refuser);
    ~HttplibAdapter();

    // Handles one exchange and takes its body. Returns true if the connection can be reused.
    bool answer(Exchange& exchange, ResponseWriter& writer);

    void endStreams();  // sinks return false from now on

private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace clerestory
