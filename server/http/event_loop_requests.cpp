// The part of the event loop that handles a request, from its first byte to its response.
#include "server/http/event_loop.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace clerestory {
namespace {

using State = RequestReader::State;

constexpr int kReadsAtOnce = 4;
// Closing a socket with unread bytes resets the connection, and the client may lose the response.
constexpr std::size_t kDrainBytes = 1 << 20;

}  // namespace

void EventLoop::read(Id id, Client& client) {
    std::array<char, 16384> buffer;
    // A few reads, then other connections; epoll reports what is left.
    for (int i = 0; i < kReadsAtOnce && client.phase == Phase::reading; ++i) {
        const std::size_t room = std::min(client.reader.room(), buffer.size());
        const ssize_t n = recv(client.writer->socket(), buffer.data(), room, MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno == EAGAIN) return watch(id, client);
        if (n <= 0) return end(id);
        client.reader.take({buffer.data(), static_cast<std::size_t>(n)});
        advance(id, client);
        if (clients_.count(id) == 0) return;
    }
}

void EventLoop::drain(Id id, Client& client) {
    std::array<char, 16384> buffer;
    while (client.drained < kDrainBytes) {
        const ssize_t n = recv(client.writer->socket(), buffer.data(), buffer.size(), MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno == EAGAIN) return;
        if (n <= 0) break;
        client.drained += static_cast<std::size_t>(n);
    }
    end(id);
}

// The socket is writable, or a worker has written to it.
void EventLoop::flush(Id id, Client& client) {
    client.writer->flush();
    if (client.phase == Phase::flushing) finishResponse(client);
    if (client.phase == Phase::handling && client.writer->broken()) clientDisconnected(client);
    advance(id, client);
}

// Processes everything that does not block, then sets the deadline and the epoll events.
void EventLoop::advance(Id id, Client& client) {
    while (client.phase == Phase::reading) {
        const State state = client.reader.state();
        if (state == State::refused) {
            refuse(client, client.reader.problem());
        } else if (state == State::complete) {
            begin(id, client);
        } else if (const auto problem = refusalOfBody(client)) {
            refuse(client, *problem);
        } else {
            break;
        }
    }
    if (client.writer->broken() && client.phase != Phase::handling) return end(id);
    const bool expectsContinue = client.phase == Phase::reading && !client.sentContinue &&
                                 client.reader.state() == State::body &&
                                 client.reader.head().expectsContinue;
    if (expectsContinue) {
        client.sentContinue = true;
        client.writer->send("HTTP/1.1 100 Continue\r\n\r\n", false);
    }
    updateDeadline(id, client);
    watch(id, client);
}

void EventLoop::begin(Id id, Client& client) {
    const RequestReader& reader = client.reader;
    auto exchange = std::make_shared<Exchange>(
        Exchange{.head = reader.head(),
                 .headBytes = headText(reader.head()),
                 .body = client.reader.takeBody(),
                 .requestId = requestIdFrom(reader.head().header("X-Request-Id")),
                 .client = hooks_.client(reader.head(), client.address),
                 .arrived = Clock::now(),
                 .cancellation = std::make_shared<CancellationToken>(),
                 .last = !reader.head().keepAlive || closing_});
    client.sentContinue = false;
    client.keepAlive = !exchange->last;
    if (const auto answer = hooks_.quick(*exchange)) {
        return reply(client, *answer, exchange->requestId, exchange->head.method == "HEAD");
    }
    client.writer->setClient(exchange->client);
    if (!client.writer->mayRequest()) {
        return reply(client, hooks_.refuse(callOf(*exchange), responsesFull()), exchange->requestId,
                     exchange->head.method == "HEAD");
    }
    client.cancellation = exchange->cancellation;
    client.halfClosed = false;
    workers_.run([this, id, exchange, writer = client.writer] {
        const bool keepAlive = hooks_.handle(*exchange, *writer);
        post({.id = id, .done = true, .keepAlive = keepAlive});
    });
    client.phase = Phase::handling;
}

void EventLoop::refuse(Client& client, const Problem& problem) {
    client.keepAlive = false;
    const Exchange exchange{.head = client.reader.head(),
                            .requestId = requestIdFrom(client.reader.head().header("X-Request-Id")),
                            .client = client.address,
                            .arrived = Clock::now()};
    reply(client, hooks_.refuse(callOf(exchange), problem), exchange.requestId,
          exchange.head.method == "HEAD");
}

// Checks a large body before it is received: access, and the memory of all large bodies together.
std::optional<Problem> EventLoop::refusalOfBody(Client& client) {
    const RequestReader& reader = client.reader;
    if (reader.state() != State::body || client.largeBody) return std::nullopt;
    const std::size_t size = reader.head().contentLength;
    if (size <= limits_.bodyBytes) return std::nullopt;
    if (auto problem = hooks_.admit(reader.head())) return problem;
    auto held =
        holdings_.take(Pool::requestBytes, hooks_.client(reader.head(), client.address), size);
    if (!held) return bodiesFull();
    client.largeBody.emplace(*std::move(held));
    return std::nullopt;
}

void EventLoop::reply(Client& client, const Answer& answer, const std::string& requestId,
                      bool isHead) {
    client.writer->send(responseBytes(answer, requestId, client.keepAlive, isHead), false);
    finishResponse(client);
}

// The response is complete: continues with the next request once it is sent, or closes.
void EventLoop::finishResponse(Client& client) {
    // A new deadline, but not for each part that is sent later: that would be any rate.
    if (client.phase != Phase::flushing) client.wait = Wait::nothing;
    client.phase = Phase::flushing;
    client.cancellation = nullptr;
    client.largeBody.reset();
    if (client.writer->pending() || client.writer->broken()) return;
    if (client.keepAlive) {
        client.phase = Phase::reading;
        client.reader.next();
    } else {
        client.phase = Phase::draining;
        client.reader = RequestReader(limits_);
        shutdown(client.writer->socket(), SHUT_WR);
    }
}

}  // namespace clerestory
