#include "tests/support/raw_client.h"

#include "tests/support/clock.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <utility>

namespace clerestory::test {
namespace {

int millisecondsUntil(Clock::time_point end) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
}

Clock::time_point in(double seconds) {
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// A connect() that a signal interrupted continues asynchronously.
bool connectionCame(int socket) {
    pollfd wait{socket, POLLOUT, 0};
    while (::poll(&wait, 1, 10'000) < 0 && errno == EINTR) {
    }
    int error = 0;
    socklen_t size = sizeof error;
    return getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
}

}  // namespace

RawClient::RawClient(int port, const char* from, int receiveBuffer) {
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (receiveBuffer > 0) {
        setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receiveBuffer, sizeof receiveBuffer);
    }
    if (from && inet_pton(AF_INET, from, &address.sin_addr) == 1) {
        (void)!::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    }
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 &&
        !(errno == EINTR && connectionCame(socket_))) {
        ::close(std::exchange(socket_, -1));
        return;
    }
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

RawClient::~RawClient() {
    if (socket_ >= 0) ::close(socket_);
}

RawClient::RawClient(RawClient&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

bool RawClient::send(std::string_view bytes) {
    const auto end = in(10.0);
    while (!bytes.empty()) {
        const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n > 0) {
            bytes.remove_prefix(static_cast<std::size_t>(n));
            continue;
        }
        if (n < 0 && errno == EINTR) continue;
        if (errno != EAGAIN) return false;
        pollfd wait{socket_, POLLOUT, 0};
        if (::poll(&wait, 1, millisecondsUntil(end)) == 0) return false;
    }
    return true;
}

std::string RawClient::receive(double seconds) {
    const auto end = in(seconds);
    std::string all;
    char buffer[16384];
    for (;;) {
        pollfd wait{socket_, POLLIN, 0};
        const int ready = ::poll(&wait, 1, millisecondsUntil(end));
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return all;
        const ssize_t n = ::recv(socket_, buffer, sizeof buffer, MSG_DONTWAIT);
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (n <= 0) return all;
        all.append(buffer, static_cast<std::size_t>(n));
    }
}

std::string RawClient::answer(double seconds) {
    const auto end = in(seconds);
    std::string all;
    char buffer[16384];
    for (;;) {
        const std::size_t head = all.find("\r\n\r\n");
        if (head != std::string::npos) {
            const std::string length = headerOf(all, "Content-Length");
            if (all.size() >= head + 4 + std::strtoul(length.c_str(), nullptr, 10)) return all;
        }
        pollfd wait{socket_, POLLIN, 0};
        const int ready = ::poll(&wait, 1, millisecondsUntil(end));
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return all;
        const ssize_t n = ::recv(socket_, buffer, sizeof buffer, MSG_DONTWAIT);
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (n <= 0) return all;
        all.append(buffer, static_cast<std::size_t>(n));
    }
}

bool RawClient::endsWithin(double seconds) {
    const auto end = in(seconds);
    char buffer[16384];
    for (;;) {
        pollfd wait{socket_, POLLIN, 0};
        const int ready = ::poll(&wait, 1, millisecondsUntil(end));
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) return false;
        const ssize_t n = ::recv(socket_, buffer, sizeof buffer, MSG_DONTWAIT);
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (n <= 0) return true;
    }
}

void RawClient::halfClose() {
    ::shutdown(socket_, SHUT_WR);
}

void RawClient::reset() {
    const linger now{1, 0};
    setsockopt(socket_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    ::close(std::exchange(socket_, -1));
}

int statusOf(std::string_view answer) {
    return answer.starts_with("HTTP/1.1 ") && answer.size() >= 12
               ? std::atoi(std::string(answer.substr(9, 3)).c_str())
               : 0;
}

std::string headerOf(std::string_view answer, std::string_view name) {
    std::string_view head = answer.substr(0, answer.find("\r\n\r\n"));
    while (!head.empty()) {
        const std::size_t end = std::min(head.find("\r\n"), head.size());
        const std::string_view line = head.substr(0, end);
        head.remove_prefix(std::min(end + 2, head.size()));
        if (line.size() > name.size() + 1 && line[name.size()] == ':' &&
            strncasecmp(line.data(), name.data(), name.size()) == 0) {
            return std::string(line.substr(line.find_first_not_of(" :", name.size())));
        }
    }
    return "";
}

std::string_view bodyOf(std::string_view answer) {
    const std::size_t end = answer.find("\r\n\r\n");
    return end == std::string_view::npos ? std::string_view() : answer.substr(end + 4);
}

std::string ask(int port, std::string_view request, double seconds, const char* from) {
    RawClient client(port, from);
    if (!client.connected()) return "";
    client.send(request);
    return client.answer(seconds);
}

std::string get(const std::string& path, const std::string& more) {
    return "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n";
}

std::string post(const std::string& path, const std::string& body, const std::string& more) {
    return "POST " + path + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
           "Content-Length: " + std::to_string(body.size()) + "\r\n" + more + "\r\n" + body;
}

double metric(int port, const std::string& name) {
    const std::string text = ask(port, get("/metrics", "Connection: close\r\n"));
    const std::size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1.0 : std::atof(text.c_str() + at + name.size() + 2);
}

}  // namespace clerestory::test
