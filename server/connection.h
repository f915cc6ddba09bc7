// One client's socket as the HTTP library's Stream, with the limits that the library lacks: bytes
// and time for a whole request, time without progress for an answer, and a way to end idle waits.
#pragma once

#include "server/render_queue.h"

#include <httplib.h>

#include <array>
#include <string>

namespace clerestory {

struct ConnectionLimits {
    std::chrono::milliseconds idle{15000};     // between requests
    std::chrono::milliseconds request{10000};  // from the first byte to the last
    std::chrono::milliseconds stalled{10000};  // of an answer nobody takes
    std::size_t requestBytes = 96 * 1024;      // head and body together
};

class Connection final : public httplib::Stream {
public:
    // `wakeFd` becomes readable when idle connections shall end. Takes the socket over.
    Connection(int socket, int wakeFd, const ConnectionLimits& limits);
    ~Connection() override;
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    // Waits for the first byte of a request; false when none came or none is wanted any more.
    bool nextRequest();

    // Ends the answer, then throws away for a moment what still comes. Closing over bytes that were
    // not read resets the connection, and the client may lose the answer.
    void drain();

    bool is_readable() const override;
    bool is_writable() const override;
    ssize_t read(char* data, std::size_t size) override;
    ssize_t write(const char* data, std::size_t size) override;
    void get_remote_ip_and_port(std::string& ip, int& port) const override;
    void get_local_ip_and_port(std::string& ip, int& port) const override;
    // The library compares it with the largest descriptor select() can take; we use poll().
    socket_t socket() const override { return 0; }

private:
    bool fill(Clock::time_point deadline);

    const int socket_;
    const int wakeFd_;
    const ConnectionLimits limits_;
    std::array<char, 8192> buffer_{};
    std::size_t begin_ = 0, end_ = 0;  // of what is buffered and not yet read
    std::size_t requestBytes_ = 0;     // read since the request's first
    Clock::time_point requestDeadline_{};
};

}  // namespace clerestory
