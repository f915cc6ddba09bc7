// A listening TCP socket. Errors of accept() never end it.
#pragma once

#include <string>

namespace clerestory {

// "host:port" as in a URL: IPv6 addresses have brackets.
std::string authorityOf(const std::string& host, int port);

class Listener {
public:
    // Port 0 selects a free one. Throws std::runtime_error with a message for the user.
    Listener(const std::string& host, int port);
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    struct Accepted {
        enum class What { connection, none, retry, exhausted };
        What what = What::none;
        int socket = -1;     // non-blocking, close-on-exec, TCP_NODELAY
        std::string client;  // its address; of IPv6 the /64 network, which is one client's
        int error = 0;       // retry, exhausted
    };
    // `retry`: this connection failed. `exhausted`: file descriptors or memory ran out.
    Accepted accept();

    int socket() const { return socket_; }
    int port() const { return port_; }
    void close();

private:
    int socket_ = -1;
    int port_ = 0;
};

}  // namespace clerestory
