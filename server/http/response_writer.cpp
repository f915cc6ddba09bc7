#include "server/http/response_writer.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace clerestory {
namespace {

// Bytes that a stream may be ahead of its reader, in addition to the socket's buffer.
constexpr std::size_t kAhead = 256 * 1024;

}  // namespace

SocketWriter::SocketWriter(int socket, UnsentBytes& all, std::function<void()> wake)
    : socket_(socket), all_(all), wake_(std::move(wake)) {}

SocketWriter::~SocketWriter() {
    all_.now -= unsent();
    close(socket_);
}

bool SocketWriter::send(std::string_view bytes, bool streamed) {
    std::unique_lock lock(mutex_);
    while (!bytes.empty() && !broken_) {
        const std::string_view piece = bytes.substr(0, kAhead);
        bytes.remove_prefix(piece.size());
        bytes_ += piece;
        all_.now += piece.size();
        if (unsent() == piece.size()) flushLocked();
        if (unsent() == 0 || broken_) continue;
        wake_();
        const bool waits = streamed || all_.now > all_.max;
        if (waits) drained_.wait(lock, [&] { return broken_ || unsent() <= kAhead; });
    }
    return !broken_;
}

void SocketWriter::flush() {
    const std::lock_guard lock(mutex_);
    flushLocked();
}

void SocketWriter::flushLocked() {
    while (!broken_ && unsent() > 0) {
        const ssize_t n =
            ::send(socket_, bytes_.data() + begin_, unsent(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && (errno == EAGAIN || errno == ENOBUFS)) break;
        if (n <= 0) {
            broken_ = true;
            break;
        }
        begin_ += static_cast<std::size_t>(n);
        sent_ += static_cast<std::size_t>(n);
        all_.now -= static_cast<std::size_t>(n);
    }
    // Frees sent bytes occasionally: each time would move the rest too often.
    if (unsent() == 0) {
        bytes_ = std::string();
        begin_ = 0;
    } else if (begin_ > (1 << 20) && begin_ > unsent()) {
        bytes_.erase(0, begin_);
        begin_ = 0;
    }
    if (broken_ || unsent() <= kAhead) drained_.notify_all();
}

void SocketWriter::abort() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    drained_.notify_all();
}

bool SocketWriter::pending() const {
    const std::lock_guard lock(mutex_);
    return unsent() > 0 && !broken_;
}

bool SocketWriter::broken() const {
    const std::lock_guard lock(mutex_);
    return broken_;
}

std::uint64_t SocketWriter::sentBytes() const {
    const std::lock_guard lock(mutex_);
    return sent_;
}

}  // namespace clerestory
