// Messages between two processes over a stream socket.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace clerestory {

enum class MessageKind : std::uint32_t {
    call,      // front to worker: a packed Call
    cancel,    // front to worker: nobody waits for the answer of this id any more
    beat,      // worker to front, every so often: it lives
    answer,    // worker to front: a packed Answer
    standing,  // worker to front: calls are answered from now on
    warm,      // worker to front: its first scene can be drawn at once
    scenes,    // worker to front: packed ids of the scenes it holds; front to worker: of those that
               // it is to hold
    failed     // worker to front: why it cannot start, in words for people; then it ends
};

struct Message {
    MessageKind kind = MessageKind::beat;
    std::uint64_t id = 0;
    std::string bytes;
};

class MessagePipe {
public:
    explicit MessagePipe(int socket) : socket_(socket) {}
    ~MessagePipe();
    MessagePipe(const MessagePipe&) = delete;
    MessagePipe& operator=(const MessagePipe&) = delete;

    // False: the other side has ended. From any thread; waits while the other side does not read.
    bool send(const Message& message);
    // Without bytes, and only if that needs no waiting. From any thread.
    void trySend(MessageKind kind, std::uint64_t id);
    // Nothing: the other side has ended, or sends what is no message. One thread.
    std::optional<Message> receive();
    // Ends every send() and receive() there is and will be, on both sides.
    void shut();

private:
    bool writeAll(const char* bytes, std::size_t size);
    bool readAll(char* bytes, std::size_t size);

    const int socket_;
    std::mutex sending_;
};

}  // namespace clerestory
