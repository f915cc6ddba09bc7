// The way in from the network: listens, guards, and hands each sound request to one function that
// answers. Knows no route.
#pragma once

#include "server/http/access.h"
#include "server/http/counters.h"
#include "server/http/httplib_adapter.h"
#include "server/http/limits.h"

namespace clerestory {

struct FrontOptions {
    std::string host = "127.0.0.1";
    int port = 8080;           // 0: any free one
    std::size_t threads = 16;  // that answer at once, at most
    FrontLimits limits;
    AccessOptions access;
};

class Front {
public:
    // Never throw. `quick` is called by the one thread that serves every connection and must not
    // wait: it answers what needs neither query nor body, and refuses what need not be read.
    struct Routes {
        std::function<std::optional<Answer>(const Call&)> quick;
        Responder respond;
        Refuser refuse;
        Access::Paths paths;
    };

    // Binds; throws std::runtime_error with one line when the port is taken or a secret is missing.
    Front(const FrontOptions& options, Routes routes);
    ~Front();

    int port() const;
    void serve();  // until stop(); returns when every answer was sent
    void stop();   // from any thread
    const FrontCounters& counters() const;

private:
    class Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace clerestory
