#include "server/connection.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace clerestory {
namespace {

int millisecondsUntil(Clock::time_point deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60'000));
}

constexpr std::chrono::milliseconds kDrain{500};
constexpr std::size_t kDrainBytes = 1 << 20;

void nameOfPeer(int (*which)(int, sockaddr*, socklen_t*), int socket, std::string& ip, int& port) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (which(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;
    char host[NI_MAXHOST], service[NI_MAXSERV];
    if (getnameinfo(reinterpret_cast<sockaddr*>(&address), size, host, sizeof host, service,
                    sizeof service, NI_NUMERICHOST | NI_NUMERICSERV) == 0) {
        ip = host;
        port = std::atoi(service);
    }
}

}  // namespace

Connection::Connection(int socket, int wakeFd, const ConnectionLimits& limits)
    : socket_(socket), wakeFd_(wakeFd), limits_(limits) {
    fcntl(socket_, F_SETFD, FD_CLOEXEC);  // importers are child processes
}

Connection::~Connection() {
    close(socket_);
}

void Connection::drain() {
    shutdown(socket_, SHUT_WR);
    const auto deadline = Clock::now() + kDrain;
    for (std::size_t total = 0; total < kDrainBytes && fill(deadline);) {
        total += end_ - begin_;
        begin_ = end_ = 0;
    }
}

bool Connection::nextRequest() {
    requestBytes_ = 0;
    if (begin_ == end_) {
        pollfd waits[] = {{socket_, POLLIN, 0}, {wakeFd_, POLLIN, 0}};
        if (poll(waits, 2, static_cast<int>(limits_.idle.count())) <= 0) return false;
        if (waits[1].revents != 0) return false;
    }
    requestDeadline_ = Clock::now() + limits_.request;
    return true;
}

// Reads what there is into the empty buffer; false at the end, at the deadline and on errors.
bool Connection::fill(Clock::time_point deadline) {
    for (;;) {
        pollfd wait{socket_, POLLIN, 0};
        const int ready = poll(&wait, 1, millisecondsUntil(deadline));
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return false;
        const ssize_t got = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
        if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (got <= 0) return false;
        begin_ = 0;
        end_ = static_cast<std::size_t>(got);
        return true;
    }
}

bool Connection::is_readable() const {
    return true;
}  // read() itself waits and gives up

bool Connection::is_writable() const {
    return true;
}  // so does write()

ssize_t Connection::read(char* data, std::size_t size) {
    if (begin_ == end_ && !fill(requestDeadline_)) return -1;
    const std::size_t count = std::min(size, end_ - begin_);
    requestBytes_ += count;
    if (requestBytes_ > limits_.requestBytes) return -1;
    std::memcpy(data, buffer_.data() + begin_, count);
    begin_ += count;
    return static_cast<ssize_t>(count);
}

ssize_t Connection::write(const char* data, std::size_t size) {
    std::size_t sent = 0;
    while (sent < size) {
        const ssize_t n = send(socket_, data + sent, size - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n > 0) {
            sent += static_cast<std::size_t>(n);
            continue;
        }
        if (n < 0 && errno == EINTR) continue;
        if (n == 0 || errno != EAGAIN) return -1;
        pollfd wait{socket_, POLLOUT, 0};
        if (poll(&wait, 1, static_cast<int>(limits_.stalled.count())) <= 0) return -1;
    }
    return static_cast<ssize_t>(size);
}

void Connection::get_remote_ip_and_port(std::string& ip, int& port) const {
    nameOfPeer(getpeername, socket_, ip, port);
}

void Connection::get_local_ip_and_port(std::string& ip, int& port) const {
    nameOfPeer(getsockname, socket_, ip, port);
}

}  // namespace clerestory
