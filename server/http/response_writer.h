// The way out to one client: whoever answers hands bytes over and goes on, the event loop sees to
// it that they leave. So a slow reader holds nobody but itself.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace clerestory {

class ResponseWriter {
public:
    virtual ~ResponseWriter() = default;
    // Takes the bytes over. `streamed`: returns only when the client has taken nearly all of them,
    // so that a stream is no faster than its reader. False: the client is gone or took nothing for
    // too long; nothing more is worth sending. From any thread.
    virtual bool send(std::string_view bytes, bool streamed) = 0;
};

// Of all outlets of a server: what lies in them together.
struct UnsentBytes {
    std::atomic<std::size_t> now{0};
    std::size_t most = 0;  // above it send() waits as for a stream
};

class SocketWriter final : public ResponseWriter {
public:
    // Takes the non-blocking socket over. `wake` tells the loop that flush() is needed.
    SocketWriter(int socket, UnsentBytes& all, std::function<void()> wake);
    ~SocketWriter() override;
    SocketWriter(const SocketWriter&) = delete;
    SocketWriter& operator=(const SocketWriter&) = delete;

    bool send(std::string_view bytes, bool streamed) override;

    // The loop's side.
    void flush();     // sends what the socket takes now
    void breakOff();  // from now on send() is false; ends its waits
    bool pending() const;
    bool broken() const;
    std::uint64_t sentBytes() const;  // since the beginning
    int socket() const { return socket_; }

private:
    void flushLocked();
    std::size_t unsent() const { return bytes_.size() - begin_; }

    const int socket_;
    UnsentBytes& all_;
    const std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::condition_variable drained_;
    std::string bytes_;
    std::size_t begin_ = 0;  // of what is not sent yet
    std::uint64_t sent_ = 0;
    bool broken_ = false;
};

}  // namespace clerestory
