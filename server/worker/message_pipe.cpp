#include "server/worker/message_pipe.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace clerestory {
namespace {

// The largest frame as float32 with its plan fits.
constexpr std::uint64_t kMaxBytes = 512ull << 20;

struct Head {
    MessageKind kind;
    std::uint32_t unused;
    std::uint64_t id, size;
};

}  // namespace

MessagePipe::~MessagePipe() {
    close(socket_);
}

bool MessagePipe::send(const Message& message) {
    const Head head{message.kind, 0, message.id, message.bytes.size()};
    const std::lock_guard lock(sending_);
    return writeAll(reinterpret_cast<const char*>(&head), sizeof head) &&
           writeAll(message.bytes.data(), message.bytes.size());
}

void MessagePipe::trySend(MessageKind kind, std::uint64_t id) {
    const std::unique_lock lock(sending_, std::try_to_lock);
    if (!lock) return;
    const Head head{kind, 0, id, 0};
    // So few bytes are sent whole or not at all.
    ::send(socket_, &head, sizeof head, MSG_NOSIGNAL | MSG_DONTWAIT);
}

std::optional<Message> MessagePipe::receive() {
    Head head{};
    if (!readAll(reinterpret_cast<char*>(&head), sizeof head)) return std::nullopt;
    if (head.kind > MessageKind::scenes || head.size > kMaxBytes) return std::nullopt;
    Message message{.kind = head.kind, .id = head.id, .bytes = std::string(head.size, '\0')};
    if (!readAll(message.bytes.data(), message.bytes.size())) return std::nullopt;
    return message;
}

void MessagePipe::shut() {
    shutdown(socket_, SHUT_RDWR);
}

bool MessagePipe::writeAll(const char* bytes, std::size_t size) {
    while (size > 0) {
        const ssize_t sent = ::send(socket_, bytes, size, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        bytes += sent;
        size -= static_cast<std::size_t>(sent);
    }
    return true;
}

bool MessagePipe::readAll(char* bytes, std::size_t size) {
    while (size > 0) {
        const ssize_t got = recv(socket_, bytes, size, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        bytes += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

}  // namespace clerestory
