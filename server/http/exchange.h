// One complete request that is being handled; responses that are written without the HTTP library;
// and the sending of a response to one client: send() buffers the bytes and returns, the event loop
// writes them to the socket, so that a slow client does not block a worker thread.
#pragma once

#include "server/base/call.h"
#include "server/base/holdings.h"
#include "server/http/request_reader.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace clerestory {

struct Exchange {
    RequestHead head;
    std::string headBytes;  // up to the blank line, inclusive
    std::string body;       // moved to the handler
    std::string requestId;
    std::string client;  // for fair shares; clients that share an address count as one
    Clock::time_point arrived;
    std::shared_ptr<CancellationToken> cancellation;
    bool last = false;  // the connection is closed after the response
};

// Refers to the exchange. The path is not decoded, query and body are empty: enough for a request
// that is rejected or needs neither.
Call callOf(const Exchange& exchange);

// Headers of every response: against MIME sniffing, framing and foreign scripts.
std::span<const std::pair<const char*, const char*>> commonHeaders();

// A complete HTTP/1.1 response; without its body if `isHead`.
std::string responseBytes(const Answer& answer, const std::string& requestId, bool keepAlive,
                          bool isHead);

// The client's id if it has up to 64 letters, digits, '-', '_' and '.'; otherwise a new one.
std::string requestIdFrom(std::string_view given);

class ResponseWriter {
public:
    virtual ~ResponseWriter() = default;
    // Buffers the bytes. If `streamed`, blocks until the client has read nearly all of them, so
    // that a stream is no faster than its reader. Returns false if the client disconnected or
    // stalled. May be called from any thread.
    virtual bool send(std::string_view bytes, bool streamed) = 0;
    // Takes the client's share for a body of this size, until sendBody() has sent it or until the
    // next call. Returns false if the client must read other responses first.
    virtual bool reserve(std::size_t bytes) {
        static_cast<void>(bytes);
        return true;
    }
    // Sends the last part of a response without copying it. Does not block. Returns false if the
    // client disconnected.
    virtual bool sendBody(std::shared_ptr<const std::string> body) { return send(*body, false); }
};

class SocketWriter final : public ResponseWriter {
public:
    // Owns the non-blocking socket. `wake` is called when the event loop must call flush().
    SocketWriter(int socket, Holdings& holdings, std::string client, std::function<void()> wake);
    ~SocketWriter() override;
    SocketWriter(const SocketWriter&) = delete;
    SocketWriter& operator=(const SocketWriter&) = delete;

    bool send(std::string_view bytes, bool streamed) override;
    bool reserve(std::size_t bytes) override;
    bool sendBody(std::shared_ptr<const std::string> body) override;

    // Called by the event loop.
    void setClient(const std::string& client);  // to which the next bytes count
    // False if the client has so many unread responses that it gets no other one.
    bool mayRequest() const;
    std::size_t bodyBytes() const;  // of the body that sendBody() has not sent yet; 0: none
    void flush();                   // writes as much as the socket accepts
    void abort();                   // send() returns false from now on and no longer blocks
    bool pending() const;
    bool broken() const;
    // Total; without those that wait in the kernel for the client to read what it has, which
    // takes bytes in large pieces.
    std::uint64_t deliveredBytes() const;
    int socket() const { return socket_; }

private:
    void flushLocked();
    std::string_view unsentPart() const;  // first `bytes_`, then `body_`
    void advance(std::size_t count);
    std::size_t copied() const { return bytes_.size() - begin_; }
    std::size_t unsent() const { return copied() + (body_ ? body_->size() - bodyBegin_ : 0); }

    const int socket_;
    Holdings& holdings_;
    const std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::condition_variable drained_;
    std::string client_;
    std::optional<Holdings::Held> held_;   // of the unsent bytes of a stream
    std::optional<Holdings::Held> share_;  // of the whole body, whose memory is freed at once
    std::string bytes_;
    std::size_t begin_ = 0;  // of the bytes that are not sent yet
    std::shared_ptr<const std::string> body_;
    std::size_t bodyBegin_ = 0;
    std::uint64_t sent_ = 0;
    bool broken_ = false;
};

}  // namespace clerestory
