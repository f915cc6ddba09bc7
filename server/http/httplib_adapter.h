// cpp-httplib between a whole request in memory and the bytes of its answer: it decodes paths and
// queries, writes heads, compresses, cuts streams into chunks. It never sees a socket.
#pragma once

#include "server/http/exchange.h"
#include "server/http/response_writer.h"

namespace clerestory {

using Responder = std::function<Answer(const Call&)>;
// The answer to a request that HTTP itself rules out; its call has no body.
using Refuser = std::function<Answer(const Call&, const Problem&)>;

class HttplibAdapter {
public:
    // Both are called on any thread and never throw.
    HttplibAdapter(const FrontLimits& limits, Responder responder, Refuser refuser);
    ~HttplibAdapter();

    // Carries one exchange through; true when the connection may carry another.
    // Takes its body.
    bool answer(Exchange& exchange, ResponseWriter& writer);

    void endStreams();  // their sinks say no from now on

private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace clerestory
