// A listening TCP socket whose accept() outlives every error.
#pragma once

#include <string>

namespace clerestory {

class Listener {
public:
    // Port 0 takes a free one. Throws std::runtime_error with one line for people.
    Listener(const std::string& host, int port);
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    struct Accepted {
        enum class What { connection, nobody, retry, exhausted };
        What what = What::nobody;
        int socket = -1;  // a connection: non-blocking, close-on-exec, without delay
        std::string
            client;     // its address; of IPv6 the network's half, since one client has the rest
        int error = 0;  // retry, exhausted
    };
    // `retry`: this one failed, the next may not. `exhausted`: descriptors or memory are short.
    Accepted accept();

    int socket() const { return socket_; }
    int port() const { return port_; }
    void close();

private:
    int socket_ = -1;
    int port_ = 0;
};

}  // namespace clerestory
