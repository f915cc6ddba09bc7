// HTTP: sockets, limits, headers that every answer carries. Knows no route: it hands each call to
// one function, which answers and never throws.
#pragma once

#include "server/call.h"
#include "server/problem.h"

#include <cstddef>
#include <memory>

namespace clerestory {

struct HttpOptions {
    std::string host = "127.0.0.1";
    int port = 8080;           // 0: any free one
    std::size_t threads = 64;  // one for each connection that is open
    std::size_t maxBody = 64 * 1024;
};

class HttpServer {
public:
    using Responder = std::function<Answer(const Call&)>;
    // The answer to a request that HTTP itself rules out; its call has no body.
    using Refuser = std::function<Answer(const Call&, const Problem&)>;

    // Binds; throws std::runtime_error with one line when the port is taken.
    HttpServer(const HttpOptions& options, Responder responder, Refuser refuser);
    ~HttpServer();

    int port() const;
    void serve();  // until stop(); returns when every answer was sent
    void stop();   // from any thread

private:
    class Library;
    std::unique_ptr<Library> library_;
};

}  // namespace clerestory
