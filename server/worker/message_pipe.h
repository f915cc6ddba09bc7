// Messages between the server and a worker process, over a stream socket.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace clerestory {

enum class MessageKind : std::uint32_t {
    // Server to worker: a request, answered by a message with the same id.
    call,        // Call
    frame,       // FrameOrder
    sceneQuery,  // id of a scene
    cancel,      // the answer of this id is no longer needed
    // Worker to server: the answer to a request.
    answer,       // Answer
    frameAnswer,  // EncodedFrame
    sceneAnswer,  // SceneReport
    refusal,      // Problem
    // Worker to server, about itself.
    alive,   // at a regular interval
    ready,   // requests are answered from now on
    warm,    // as alive; the shaders of the default scene are compiled
    failed,  // it cannot start and ends; the message for people
    // Ids of scenes. Worker to server: those that it has loaded; server to worker: those to load.
    scenes
};

struct Message {
    MessageKind kind = MessageKind::alive;
    std::uint64_t id = 0;
    std::string bytes;
};

class MessagePipe {
public:
    explicit MessagePipe(int socket) : socket_(socket) {}
    ~MessagePipe();
    MessagePipe(const MessagePipe&) = delete;
    MessagePipe& operator=(const MessagePipe&) = delete;

    // Returns false if the other side has ended. Thread-safe; waits while the other side does not
    // read.
    bool send(const Message& message);
    // Sends a message without bytes, unless this would block. Thread-safe.
    void trySend(MessageKind kind, std::uint64_t id);
    // Empty if the other side has ended or sent a malformed message. For one thread.
    std::optional<Message> receive();
    // Ends all present and future calls of send() and receive(), on both sides.
    void shut();

private:
    bool writeAll(const char* bytes, std::size_t size);
    bool readAll(char* bytes, std::size_t size);

    const int socket_;
    std::mutex sending_;
};

}  // namespace clerestory
