#include "server/http/event_loop.h"

#include "server/base/log.h"
#include "server/http/wire.h"

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
// Less than this within FrontLimits::write or body is no progress: else a byte a second would be.
constexpr std::uint64_t kProgress = 4096, kBodyProgress = 512 * 1024;
constexpr milliseconds kDrain{500};
constexpr milliseconds kAcceptPause{20}, kNotYetIdle{250}, kMemoryPause{1};
// At the end: for a request that is on its way, and for one that has begun to come.
constexpr milliseconds kLastCall{150};
constexpr milliseconds kLastWord{2000};
constexpr int kAcceptedAtOnce = 64, kAcceptedAtEnd = 4096;

double seconds(milliseconds time) {
    return std::chrono::duration<double>(time).count();
}

}  // namespace

EventLoop::EventLoop(Listener& listener, const FrontLimits& limits, std::size_t threads,
                     Hooks hooks, FrontCounters& counters)
    : listener_(listener),
      limits_(limits),
      hooks_(std::move(hooks)),
      counters_(counters),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      workers_(threads) {
    unsent_.most = limits.unsentBytes;
    epoll_event event{.events = EPOLLIN, .data = {.u64 = kWake}};
    if (epoll_ < 0 || wake_ < 0 || epoll_ctl(epoll_, EPOLL_CTL_ADD, wake_, &event) != 0) {
        throw std::runtime_error("cannot wait for connections: " + std::string(strerror(errno)));
    }
}

EventLoop::~EventLoop() {
    close(wake_);
    close(epoll_);
}

void EventLoop::stop() {
    stopping_ = true;
    eventfd_write(wake_, 1);
}

// Whoever waits for it would wait for ever, so it waits for memory.
void EventLoop::post(const Letter& letter) {
    for (bool given = false; !given;) {
        try {
            const std::lock_guard lock(mutex_);
            letters_.push_back(letter);
            given = true;
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
                                     millisecondsToNext());
        for (std::size_t i = 0; static_cast<int>(i) < count; ++i) {
            const Id id = events[i].data.u64;
            if (id == kListener) {
                accept(kAcceptedAtOnce);
            } else if (id == kWake) {
                readLetters();
            } else {
                with(id, [&](Client& client) { handle(id, events[i].events, client); });
            }
        }
        expire();
        if (stopping_ && !closing_) beginStopping();
    }
}

int EventLoop::millisecondsToNext() const {
    auto next = acceptAgain_;
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
    } catch (const std::exception& error) {  // memory or threads, mostly
        logError({"a connection failed: ", error.what()});
        end(id);
    }
}

// --- connections come and go

void EventLoop::accept(int most) {
    using What = Listener::Accepted::What;
    for (int i = 0; i < most; ++i) {
        Listener::Accepted accepted = listener_.accept();
        if (accepted.what == What::nobody) return;
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
            welcome(accepted);
        } catch (const std::exception& error) {  // memory: it costs this connection
            ++counters_.acceptErrors;
            logError({"a connection failed: ", error.what()});
        }
    }
}

void EventLoop::welcome(Listener::Accepted& accepted) {
    const Id id = nextId_++;
    std::shared_ptr<SocketWriter> writer;
    try {
        writer = std::make_shared<SocketWriter>(accepted.socket, unsent_,
                                                [this, id] { post({.id = id}); });
    } catch (...) {
        close(accepted.socket);  // nobody owns it yet
        throw;
    }
    if (clients_.size() >= limits_.connections && !evict(milliseconds(0))) return turnAway(*writer);
    clients_.emplace(id, Client{.writer = std::move(writer),
                                .reader = RequestReader(limits_),
                                .address = std::move(accepted.client)});
    counters_.open = clients_.size();
    with(id, [&](Client& client) { advance(id, client); });
}

void EventLoop::turnAway(SocketWriter& writer) {
    ++counters_.turnedAway;
    const Exchange nothing{.requestId = requestIdFrom("")};
    writer.send(wireBytes(hooks_.refuse(callOf(nothing), tooManyConnections()), nothing.requestId,
                          false, false),
                false);
}

// The connection that asks least: one without a request before one whose request is slow; of these
// the one that would end soonest anyway. Whoever is being answered stays, and whoever has only just
// come: the next has no better claim.
bool EventLoop::evict(milliseconds youngest) {
    const auto now = Clock::now();
    Id slow = 0;
    for (const auto& [deadline, id] : deadlines_.inOrder()) {
        const Client& client = clients_.at(id);
        const bool asks = client.phase == Phase::reading && client.reader.state() != State::idle;
        if (now - (deadline - timeFor(client.wait)) < youngest) continue;
        if (client.phase == Phase::draining || (client.phase == Phase::reading && !asks)) {
            ++counters_.evicted;
            end(id);
            return true;
        }
        if (asks && slow == 0) slow = id;
    }
    if (slow == 0) return false;
    ++counters_.evicted;
    end(slow);
    return true;
}

// Descriptors or memory are short: lets the machine breathe.
void EventLoop::pauseAccepting(int error) {
    if (counters_.acceptErrors++ % 100 == 0) {
        logWarning({"accept: ", strerror(error)});
    }
    epoll_event event{.events = 0, .data = {.u64 = kListener}};
    epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_.socket(), &event);
    acceptAgain_ = Clock::now() + kAcceptPause;
}

void EventLoop::end(Id id) {
    const auto found = clients_.find(id);
    if (found == clients_.end()) return;
    Client& client = found->second;
    deadlines_.forget(id);
    if (client.watched) epoll_ctl(epoll_, EPOLL_CTL_DEL, client.writer->socket(), nullptr);
    client.writer->breakOff();
    largeBodies_ -= client.large;
    clients_.erase(found);
    counters_.open = clients_.size();
}

// --- what epoll and the workers tell

void EventLoop::readLetters() {
    eventfd_t ignored = 0;
    eventfd_read(wake_, &ignored);
    std::vector<Letter> letters;
    {
        const std::lock_guard lock(mutex_);
        letters.swap(letters_);
    }
    for (const Letter& letter : letters) {
        with(letter.id, [&](Client& client) { readLetter(letter, client); });
    }
}

void EventLoop::readLetter(const Letter& letter, Client& client) {
    if (!letter.answered) return flushed(letter.id, client);
    client.keepAlive = letter.keepAlive;
    answered(client);
    advance(letter.id, client);
}

void EventLoop::handle(Id id, std::uint32_t events, Client& client) {
    const bool dead = (events & (EPOLLHUP | EPOLLERR)) != 0;
    if (client.phase == Phase::reading) return read(id, client);
    if (dead && client.phase != Phase::serving) return end(id);
    if (dead) {
        client.writer->breakOff();
        left(client);
        // epoll would tell it for ever. The worker's letter ends the connection.
        epoll_ctl(epoll_, EPOLL_CTL_DEL, client.writer->socket(), nullptr);
        client.watched = false;
        return deadlines_.forget(id);
    }
    if ((events & EPOLLRDHUP) != 0 && client.phase == Phase::serving) left(client);
    if ((events & EPOLLOUT) != 0) return flushed(id, client);
    if (client.phase == Phase::draining) return drain(id, client);
    watch(id, client);
}

// It has closed its side. What is cheap it may still read; work that waits is not worth beginning.
void EventLoop::left(Client& client) {
    if (client.halfClosed) return;
    client.halfClosed = true;
    ++counters_.clientsLeft;
    if (client.cancellation) client.cancellation->leave();
}

// --- time

EventLoop::Wait EventLoop::waitOf(const Client& client) const {
    switch (client.phase) {
        case Phase::serving:
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
            return closing_ ? kLastCall : limits_.idle;
        case Wait::head:
            return closing_ ? std::min(kLastWord, limits_.head) : limits_.head;
        case Wait::body:
            return closing_ ? std::min(kLastWord, limits_.body) : limits_.body;
        case Wait::write:
            return limits_.write;
        case Wait::drain:
        case Wait::nothing:
            break;
    }
    return kDrain;
}

// More of the same does not buy time, except for whoever takes an answer, or sends a large body, at
// a fair pace.
void EventLoop::updateDeadline(Id id, Client& client) {
    const Wait wait = waitOf(client);
    const bool writes = wait == Wait::write, reads = wait == Wait::body;
    const std::uint64_t moved = writes  ? client.writer->sentBytes()
                                : reads ? client.reader.bodyBytes()
                                        : 0;
    const bool progress =
        (writes || reads) && moved >= client.moved + (writes ? kProgress : kBodyProgress);
    if (wait == client.wait && !progress) return;
    client.wait = wait;
    client.moved = moved;
    if (wait == Wait::nothing) return deadlines_.forget(id);
    deadlines_.set(id, Clock::now() + timeFor(wait));
}

void EventLoop::expire() {
    const auto now = Clock::now();
    if (now >= acceptAgain_) {
        acceptAgain_ = Clock::time_point::max();
        epoll_event event{.events = EPOLLIN, .data = {.u64 = kListener}};
        if (!closing_) epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_.socket(), &event);
    }
    while (const auto id = deadlines_.due(now)) {
        with(*id, [&](Client& client) { expired(*id, client); });
    }
}

void EventLoop::expired(Id id, Client& client) {
    const State state = client.reader.state();
    if (client.phase == Phase::reading && state != State::idle) {
        ++counters_.timeouts;
        const bool head = state == State::head;
        refuse(client,
               requestTimeout(head ? "head" : "body", seconds(head ? limits_.head : limits_.body)));
        return advance(id, client);
    }
    if (client.phase == Phase::serving) {  // of a stream
        ++counters_.stalled;
        client.writer->breakOff();
        left(client);
        return deadlines_.forget(id);
    }
    if (client.phase == Phase::flushing) ++counters_.stalled;
    end(id);
}

// --- the rest

void EventLoop::watch(Id id, Client& client) {
    std::uint32_t interest = 0;
    switch (client.phase) {
        case Phase::reading:
        case Phase::draining:
            interest = EPOLLIN;
            break;
        case Phase::serving:
            if (!client.halfClosed) interest |= EPOLLRDHUP;
            [[fallthrough]];
        case Phase::flushing:
            if (client.writer->pending()) interest |= EPOLLOUT;
            break;
    }
    if (client.watched && interest == client.interest) return;
    if (!client.watched && client.phase == Phase::serving && client.writer->broken()) return;
    epoll_event event{.events = interest, .data = {.u64 = id}};
    epoll_ctl(epoll_, client.watched ? EPOLL_CTL_MOD : EPOLL_CTL_ADD, client.writer->socket(),
              &event);
    client.watched = true;
    client.interest = interest;
}

// Nobody new, and those that are here ask no more than what they have begun.
void EventLoop::beginStopping() {
    closing_ = true;
    accept(kAcceptedAtEnd);  // who has connected already gets an answer
    epoll_ctl(epoll_, EPOLL_CTL_DEL, listener_.socket(), nullptr);
    listener_.close();
    for (const auto& [id, client] : clients_) {
        if (client.phase != Phase::reading) continue;
        deadlines_.shorten(id, Clock::now() + timeFor(client.wait));
    }
}

}  // namespace clerestory
