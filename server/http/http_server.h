// The HTTP server: listens, checks limits and access, and passes each valid request to one handler.
// Knows no routes.
#pragma once

#include "server/http/access.h"
#include "server/http/httplib_adapter.h"
#include "server/http/limits.h"

namespace clerestory {

struct HttpServerOptions {
    std::string host = "127.0.0.1";
    int port = 8080;           // 0: any free port
    std::size_t threads = 16;  // maximum number of concurrent handlers
    HttpLimits limits;
    AccessOptions access;
};

class HttpServer {
public:
    // None of them throws. `quick` is called by the event loop's thread and must not block: it
    // handles requests that need neither query nor body, and rejects others without parsing them.
    // The call has no query and no body; `body` is as it was sent.
    struct Routes {
        std::function<std::optional<Answer>(const Call&, std::string_view body)> quick;
        Responder respond;
        Refuser refuse;
        Access::Paths paths;
    };

    // Binds. Throws std::runtime_error if the port is in use or a secret cannot be read.
    HttpServer(const HttpServerOptions& options, Routes routes);
    ~HttpServer();

    int port() const;
    void serve();  // until stop(); returns when every response is sent
    void stop();   // from any thread
    const ConnectionCounters& counters() const;
    // What each client holds; routes take their parts of it.
    Holdings& holdings();

private:
    class Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace clerestory
