#include "server/http/listener.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr int kBacklog = 1024;  // a short one delays bursts of clients by a second

std::string nameOf(const sockaddr_storage& address) {
    char text[INET6_ADDRSTRLEN] = "";
    if (address.ss_family == AF_INET) {
        const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
        inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
    } else if (address.ss_family == AF_INET6) {
        in6_addr v6 = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
        if (IN6_IS_ADDR_V4MAPPED(&v6)) {
            inet_ntop(AF_INET, v6.s6_addr + 12, text, sizeof text);
        } else {
            if (!IN6_IS_ADDR_LOOPBACK(&v6)) std::memset(v6.s6_addr + 8, 0, 8);
            inet_ntop(AF_INET6, &v6, text, sizeof text);
        }
    }
    return text;
}

int bound(const addrinfo& at) {
    const int fd = ::socket(at.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    // Not SO_REUSEPORT: a second server on a taken port must fail, not share it.
    const int on = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(fd, at.ai_addr, at.ai_addrlen) == 0 && listen(fd, kBacklog) == 0) return fd;
    ::close(fd);
    return -1;
}

int portOf(int fd) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.ss_family == AF_INET6
                     ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                     : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

}  // namespace

std::string authorityOf(const std::string& host, int port) {
    const bool isV6 = host.find(':') != std::string::npos && !host.starts_with('[');
    return (isV6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Listener::Listener(const std::string& host, int port) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    const bool bracketed = host.starts_with('[') && host.ends_with(']');
    const std::string name = bracketed ? host.substr(1, host.size() - 2) : host;
    addrinfo* found = nullptr;
    if (getaddrinfo(name.c_str(), std::to_string(port).c_str(), &hints, &found) == 0) {
        const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, freeaddrinfo);
        for (const addrinfo* at = found; at && socket_ < 0; at = at->ai_next) socket_ = bound(*at);
    }
    if (socket_ < 0) {
        throw std::runtime_error("cannot listen on " + authorityOf(host, port) +
                                 ": the port is in use or the address is not local");
    }
    port_ = portOf(socket_);
}

Listener::~Listener() {
    close();
}

void Listener::close() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
}

Listener::Accepted Listener::accept() {
    using What = Accepted::What;
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    const int fd = accept4(socket_, reinterpret_cast<sockaddr*>(&address), &size,
                           SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd >= 0) {
        const int on = 1;  // otherwise delayed ACKs add 40 ms on a persistent connection
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        // Otherwise the kernel takes megabytes at once, and says nothing while they are read.
        const int unsent = 128 * 1024;
        setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent, sizeof unsent);
        return {.what = What::connection, .socket = fd, .client = nameOf(address)};
    }
    switch (errno) {
        case EAGAIN:
            return {};
        // Errors of one connection; see accept(2), TCP/IP.
        case EINTR:
        case ECONNABORTED:
        case EPROTO:
        case ENOPROTOOPT:
        case EOPNOTSUPP:
        case ENETDOWN:
        case ENETUNREACH:
        case EHOSTDOWN:
        case EHOSTUNREACH:
        case ENONET:
        case EPERM:
            return {.what = What::retry, .error = errno};
        default:  // EMFILE, ENFILE, ENOBUFS, ENOMEM, and unexpected errors
            return {.what = What::exhausted, .error = errno};
    }
}

}  // namespace clerestory
