#include "server/http/event_loop.h"

#include "server/base/log.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>

namespace clerestory {
namespace {

using std::chrono::milliseconds;
using State = RequestReader::State;

constexpr std::uint64_t kListener = 0, kWake = 1;
// Bytes that a client must read or send within HttpLimits::write or body; otherwise one byte per
// second would count as progress.
constexpr std::uint64_t kProgress = 4096, kBodyProgress = 512 * 1024;
// A large response is read within that many times HttpLimits::write, because it holds memory.
constexpr std::uint64_t kWritePeriods = 30;
constexpr milliseconds kDrainTime{500};
constexpr milliseconds kAcceptPause{20}, kNotYetIdle{250}, kMemoryPause{1};
// While stopping: for idle connections, and for requests that are being received.
constexpr milliseconds kStopIdle{150};
constexpr milliseconds kStopReceive{2000};
constexpr int kAcceptedAtOnce = 64, kAcceptedAtEnd = 4096;

double seconds(milliseconds time) {
    return std::chrono::duration<double>(time).count();
}

}  // namespace

EventLoop::EventLoop(Listener& listener, const HttpLimits& limits, std::size_t threads, Hooks hooks,
                     ConnectionCounters& counters, Holdings& holdings)
    : listener_(listener),
      limits_(limits),
      hooks_(std::move(hooks)),
      counters_(counters),
      holdings_(holdings),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      workers_(threads) {
    epoll_event event{.events = EPOLLIN, .data = {.u64 = kWake}};
    if (epoll_ < 0 || wake_ < 0 || epoll_ctl(epoll_, EPOLL_CTL_ADD, wake_, &event) != 0) {
        throw std::runtime_error("cannot wait for connections: " + std::string(strerror(errno)));
    }
}

EventLoop::~EventLoop() {
    workers_.finish();  // their messages write to wake_
    close(wake_);
    close(epoll_);
}

void EventLoop::stop() {
    stopping_ = true;
    eventfd_write(wake_, 1);
}

// A lost message would block its connection for ever, so this retries until there is memory.
void EventLoop::post(const Message& message) {
    for (bool posted = false; !posted;) {
        try {
            const std::lock_guard lock(mutex_);
            messages_.push_back(message);
            posted = true;
        } catch (const std::bad_alloc&) {
            std::this_thread::sleep_for(kMemoryPause);
        }
    }
    eventfd_write(wake_, 1);
}

void EventLoop::run() {
    epoll_event event{.events = EPOLLIN, .data = {.u64 = kListener}};
    epoll_ctl(epoll_, EPOLL_CTL_ADD, listener_.socket(), &event);
    std::array<epoll_event, 64> events{};
    while (!closing_ || !clients_.empty()) {
        const int count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()),
                                     millisecondsToNextDeadline());
        for (std::size_t i = 0; static_cast<int>(i) < count; ++i) {
            const Id id = events[i].data.u64;
            if (id == kListener) {
                accept(kAcceptedAtOnce);
            } else if (id == kWake) {
                readMessages();
            } else {
                with(id, [&](Client& client) { handle(id, events[i].events, client); });
            }
        }
        expireDeadlines();
        if (stopping_ && !closing_) beginStopping();
    }
}

int EventLoop::millisecondsToNextDeadline() const {
    auto next = acceptPausedUntil_;
    const auto& order = deadlines_.inOrder();
    if (!order.empty()) next = std::min(next, order.begin()->first);
    if (next == Clock::time_point::max()) return -1;
    const auto left = std::chrono::ceil<milliseconds>(next - Clock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60'000));
}

template <class Act>
void EventLoop::with(Id id, Act act) {
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    try {
        act(found->second);
    } catch (const std::exception& error) {  // usually out of memory or threads
        logError({"a connection failed: ", error.what()});
        end(id);
    }
}

// --- connections

void EventLoop::accept(int maxCount) {
    using What = Listener::Accepted::What;
    for (int i = 0; i < maxCount; ++i) {
        Listener::Accepted accepted = listener_.accept();
        if (accepted.what == What::none) return;
        const bool full = accepted.error == EMFILE || accepted.error == ENFILE;
        if (accepted.what == What::exhausted && !(full && evict(kNotYetIdle))) {
            return pauseAccepting(accepted.error);
        }
        if (accepted.what != What::connection) {
            ++counters_.acceptErrors;
            continue;
        }
        ++counters_.accepted;
        try {
            addClient(accepted);
        } catch (const std::exception& error) {  // out of memory: closes this connection
            ++counters_.acceptErrors;
            logError({"a connection failed: ", error.what()});
        }
    }
}

void EventLoop::addClient(Listener::Accepted& accepted) {
    const Id id = nextId_++;
    std::shared_ptr<SocketWriter> writer;
    try {
        writer = std::make_shared<SocketWriter>(accepted.socket, holdings_, accepted.client,
                                                [this, id] { post({.id = id}); });
    } catch (...) {
        close(accepted.socket);  // not owned yet
        throw;
    }
    if (clients_.size() >= limits_.connections && !evict(milliseconds(0))) return reject(*writer);
    clients_.emplace(id,
                     Client{.writer = std::move(writer),
                            .reader = RequestReader(limits_),
                            .address = accepted.client,
                            .connection = holdings_.take(Pool::connections, accepted.client, 1)});
    counters_.open = clients_.size();
    with(id, [&](Client& client) { advance(id, client); });
}

void EventLoop::reject(SocketWriter& writer) {
    ++counters_.rejected;
    const Exchange nothing{.requestId = requestIdFrom("")};
    writer.send(responseBytes(hooks_.refuse(callOf(nothing), tooManyConnections()),
                              nothing.requestId, false, false),
                false);
}

// Closes the most dispensable connection: one without a request, otherwise one with an incomplete
// request; of these the one whose deadline is next. Connections with a running request and those
// younger than `minimumAge` stay. The client with the most connections loses one first.
bool EventLoop::evict(milliseconds minimumAge) {
    const Holdings::Usage held = holdings_.usage(Pool::connections);
    return (held.clients > 1 && evict(minimumAge, held.greatestClient)) || evict(minimumAge, "");
}

// Of this client; empty: of any.
bool EventLoop::evict(milliseconds minimumAge, const std::string& address) {
    const auto now = Clock::now();
    Id slow = 0;
    for (const auto& [deadline, id] : deadlines_.inOrder()) {
        const Client& client = clients_.at(id);
        const bool receiving =
            client.phase == Phase::reading && client.reader.state() != State::idle;
        if (!address.empty() && client.address != address) continue;
        if (now - (deadline - timeFor(client.wait)) < minimumAge) continue;
        if (client.phase == Phase::draining || (client.phase == Phase::reading && !receiving)) {
            ++counters_.evicted;
            end(id);
            return true;
        }
        if (receiving && slow == 0) slow = id;
    }
    if (slow == 0) return false;
    ++counters_.evicted;
    end(slow);
    return true;
}

// File descriptors or memory ran out: stops accepting for a moment.
void EventLoop::pauseAccepting(int error) {
    if (counters_.acceptErrors++ % 100 == 0) {
        logWarning({"accept: ", strerror(error)});
    }
    epoll_event event{.events = 0, .data = {.u64 = kListener}};
    epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_.socket(), &event);
    acceptPausedUntil_ = Clock::now() + kAcceptPause;
}

void EventLoop::end(Id id) {
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    Client& client = found->second;
    deadlines_.forget(id);
    if (client.watched) epoll_ctl(epoll_, EPOLL_CTL_DEL, client.writer->socket(), nullptr);
    client.writer->abort();
    clients_.erase(found);
    counters_.open = clients_.size();
}

// --- events of epoll and messages of workers

void EventLoop::readMessages() {
    eventfd_t ignored = 0;
    eventfd_read(wake_, &ignored);
    std::vector<Message> messages;
    {
        const std::lock_guard lock(mutex_);
        messages.swap(messages_);
    }
    for (const Message& message : messages) {
        with(message.id, [&](Client& client) { readMessage(message, client); });
    }
}

void EventLoop::readMessage(const Message& message, Client& client) {
    if (!message.done) return flush(message.id, client);
    client.keepAlive = message.keepAlive;
    finishResponse(client);
    advance(message.id, client);
}

void EventLoop::handle(Id id, std::uint32_t events, Client& client) {
    const bool hungUp = (events & (EPOLLHUP | EPOLLERR)) != 0;
    if (client.phase == Phase::reading) return read(id, client);
    if (hungUp && client.phase != Phase::handling) return end(id);
    if (hungUp) {
        client.writer->abort();
        clientDisconnected(client);
        // epoll would report it for ever. The worker's message closes the connection.
        epoll_ctl(epoll_, EPOLL_CTL_DEL, client.writer->socket(), nullptr);
        client.watched = false;
        return deadlines_.forget(id);
    }
    if ((events & EPOLLRDHUP) != 0 && client.phase == Phase::handling) clientDisconnected(client);
    if ((events & EPOLLOUT) != 0) return flush(id, client);
    if (client.phase == Phase::draining) return drain(id, client);
    watch(id, client);
}

// The client closed its side: cancels queued work. It can still read a response.
void EventLoop::clientDisconnected(Client& client) {
    if (client.halfClosed) return;
    client.halfClosed = true;
    ++counters_.disconnected;
    if (client.cancellation) client.cancellation->cancel();
}

// --- deadlines

EventLoop::Wait EventLoop::waitOf(const Client& client) const {
    switch (client.phase) {
        case Phase::handling:
        case Phase::flushing:
            return client.writer->pending() ? Wait::write : Wait::nothing;
        case Phase::draining:
            return Wait::drain;
        case Phase::reading:
            break;
    }
    const State state = client.reader.state();
    return state == State::idle ? Wait::idle : state == State::head ? Wait::head : Wait::body;
}

milliseconds EventLoop::timeFor(Wait wait) const {
    switch (wait) {
        case Wait::idle:
            return closing_ ? kStopIdle : limits_.idle;
        case Wait::head:
            return closing_ ? std::min(kStopReceive, limits_.head) : limits_.head;
        case Wait::body:
            return closing_ ? std::min(kStopReceive, limits_.body) : limits_.body;
        case Wait::write:
            return limits_.write;
        case Wait::drain:
        case Wait::nothing:
            break;
    }
    return kDrainTime;
}

// Returns whether it was extended. A deadline is extended only when the wait changes, or when a
// client reads a response or sends a large body fast enough. While stopping, a client has the whole
// time once.
bool EventLoop::updateDeadline(Id id, Client& client) {
    const Wait wait = waitOf(client);
    const bool writes = wait == Wait::write, reads = wait == Wait::body;
    const std::uint64_t transferred = writes  ? client.writer->deliveredBytes()
                                      : reads ? client.reader.bodyBytes()
                                              : 0;
    const std::uint64_t least =
        writes ? std::max<std::uint64_t>(kProgress, client.writer->bodyBytes() / kWritePeriods)
               : kBodyProgress;
    const bool progress = (writes || reads) && transferred >= client.transferred + least;
    if (wait == client.wait && (!progress || (writes && closing_))) return false;
    client.wait = wait;
    client.transferred = transferred;
    if (wait == Wait::nothing) {
        deadlines_.forget(id);
        return false;
    }
    deadlines_.set(id, Clock::now() + timeFor(wait));
    return true;
}

void EventLoop::expireDeadlines() {
    const auto now = Clock::now();
    if (now >= acceptPausedUntil_) {
        acceptPausedUntil_ = Clock::time_point::max();
        epoll_event event{.events = EPOLLIN, .data = {.u64 = kListener}};
        if (!closing_) epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_.socket(), &event);
    }
    while (const auto id = deadlines_.due(now)) {
        with(*id, [&](Client& client) { deadlineExpired(*id, client); });
    }
}

void EventLoop::deadlineExpired(Id id, Client& client) {
    const State state = client.reader.state();
    // A reader may have taken much since the last event: the kernel sends on without one.
    if (client.wait == Wait::write && updateDeadline(id, client)) return;
    if (client.phase == Phase::reading && state != State::idle) {
        ++counters_.timeouts;
        const bool head = state == State::head;
        refuse(client,
               requestTimeout(head ? "head" : "body", seconds(head ? limits_.head : limits_.body)));
        return advance(id, client);
    }
    if (client.phase == Phase::handling) {  // a stream that is not read
        ++counters_.stalled;
        client.writer->abort();
        clientDisconnected(client);
        return deadlines_.forget(id);
    }
    if (client.phase == Phase::flushing) ++counters_.stalled;
    end(id);
}

// --- epoll and shutdown

void EventLoop::watch(Id id, Client& client) {
    std::uint32_t interest = 0;
    switch (client.phase) {
        case Phase::reading:
        case Phase::draining:
            interest = EPOLLIN;
            break;
        case Phase::handling:
            if (!client.halfClosed) interest |= EPOLLRDHUP;
            [[fallthrough]];
        case Phase::flushing:
            if (client.writer->pending()) interest |= EPOLLOUT;
            break;
    }
    if (client.watched && interest == client.interest) return;
    if (!client.watched && client.phase == Phase::handling && client.writer->broken()) return;
    epoll_event event{.events = interest, .data = {.u64 = id}};
    epoll_ctl(epoll_, client.watched ? EPOLL_CTL_MOD : EPOLL_CTL_ADD, client.writer->socket(),
              &event);
    client.watched = true;
    client.interest = interest;
}

// Accepts no new connections; existing ones may only finish the request they have begun.
void EventLoop::beginStopping() {
    closing_ = true;
    accept(kAcceptedAtEnd);  // clients that have already connected get a response
    epoll_ctl(epoll_, EPOLL_CTL_DEL, listener_.socket(), nullptr);
    listener_.close();
    for (const auto& [id, client] : clients_) {
        const bool writes = client.wait == Wait::write;
        if (client.phase != Phase::reading && !writes) continue;
        deadlines_.shorten(id, Clock::now() + timeFor(client.wait));
    }
}

}  // namespace clerestory
