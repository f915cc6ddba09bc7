// One thread with epoll serves every connection: it accepts, reads complete requests within the
// limits, passes them to worker threads, sends their responses, and closes connections that are too
// slow.
//
// Does not: know routes; block.
#pragma once

#include "server/base/process.h"
#include "server/base/worker_pool.h"
#include "server/http/exchange.h"
#include "server/http/limits.h"
#include "server/http/listener.h"
#include "server/http/request_reader.h"

#include <cstdint>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

namespace clerestory {

// Deadlines by id, in the order of time.
class Deadlines {
public:
    using Id = std::uint64_t;

    void set(Id id, Clock::time_point time) {
        forget(id);
        times_[id] = time;
        order_.emplace(time, id);
    }

    // Sets the deadline unless the present one is earlier.
    void shorten(Id id, Clock::time_point time) {
        const auto found = times_.find(id);
        if (found == times_.end() || found->second > time) set(id, time);
    }

    void forget(Id id) {
        const auto found = times_.find(id);
        if (found == times_.end()) return;
        order_.erase({found->second, id});
        times_.erase(found);
    }

    std::optional<Id> due(Clock::time_point now) const {
        if (order_.empty() || order_.begin()->first > now) return std::nullopt;
        return order_.begin()->second;
    }

    const std::set<std::pair<Clock::time_point, Id>>& inOrder() const { return order_; }

private:
    std::unordered_map<Id, Clock::time_point> times_;
    std::set<std::pair<Clock::time_point, Id>> order_;
};

class EventLoop {
public:
    struct Hooks {
        // The client for fair shares.
        std::function<std::string(const RequestHead&, const std::string& address)> client;
        // On the loop's thread, must not block: the response to a request that needs no worker, or
        // nothing.
        std::function<std::optional<Answer>(const Exchange&)> quick;
        // Why a large body is rejected before it is received, or nothing.
        std::function<std::optional<Problem>(const RequestHead&)> admit;
        // The response to a rejected request.
        std::function<Answer(const Call&, const Problem&)> refuse;
        // On a worker's thread; returns true if the connection can be reused. Must not throw.
        std::function<bool(Exchange&, ResponseWriter&)> handle;
    };

    EventLoop(Listener& listener, const HttpLimits& limits, std::size_t threads, Hooks hooks,
              ConnectionCounters& counters, Holdings& holdings);
    ~EventLoop();
    EventLoop(const EventLoop&) = delete;
    EventLoop& operator=(const EventLoop&) = delete;

    void run();   // until stop(), then until every request has its response
    void stop();  // from any thread

private:
    using Id = Deadlines::Id;
    enum class Phase {
        reading,   // a request, or waiting for one
        handling,  // by a worker
        flushing,  // the response is complete but not sent
        draining,  // our side is closed; discards what the client still sends
    };
    // What a deadline applies to.
    enum class Wait { nothing, idle, head, body, write, drain };
    struct Client {
        std::shared_ptr<SocketWriter> writer;
        RequestReader reader;
        std::string address;
        std::shared_ptr<CancellationToken> cancellation;  // of the exchange that is handled
        Phase phase = Phase::reading;
        Wait wait = Wait::nothing;
        std::uint64_t transferred = 0;  // bytes of the body or response, when the deadline was set
        std::optional<Holdings::Held> connection, largeBody;
        std::uint32_t interest = 0;  // of epoll
        bool watched = false;        // by epoll
        bool halfClosed = false;
        bool keepAlive = true;
        bool sentContinue = false;
        std::size_t drained = 0;  // bytes
    };
    struct Message {  // of a worker to the loop
        Id id = 0;
        bool done = false;  // otherwise there are bytes to send
        bool keepAlive = false;
    };

    void post(const Message& message);
    void readMessages();
    void readMessage(const Message& message, Client& client);
    void handle(Id id, std::uint32_t events, Client& client);
    // Calls `act` on the client if it is still connected; an exception closes the connection.
    template <class Act>
    void with(Id id, Act act);
    void accept(int maxCount);
    void addClient(Listener::Accepted& accepted);
    void reject(SocketWriter& writer);
    bool evict(std::chrono::milliseconds minimumAge);
    bool evict(std::chrono::milliseconds minimumAge, const std::string& address);
    void pauseAccepting(int error);
    void read(Id id, Client& client);
    void advance(Id id, Client& client);
    void begin(Id id, Client& client);
    void reply(Client& client, const Answer& answer, const std::string& requestId, bool isHead);
    void refuse(Client& client, const Problem& problem);
    std::optional<Problem> refusalOfBody(Client& client);
    void finishResponse(Client& client);
    void flush(Id id, Client& client);
    void drain(Id id, Client& client);
    void clientDisconnected(Client& client);
    void expireDeadlines();
    void deadlineExpired(Id id, Client& client);
    void beginStopping();
    void watch(Id id, Client& client);
    Wait waitOf(const Client& client) const;
    std::chrono::milliseconds timeFor(Wait wait) const;
    bool updateDeadline(Id id, Client& client);
    void end(Id id);
    int millisecondsToNextDeadline() const;

    Listener& listener_;
    const HttpLimits limits_;
    const Hooks hooks_;
    ConnectionCounters& counters_;
    Holdings& holdings_;
    int epoll_ = -1;
    int wake_ = -1;
    std::atomic<bool> stopping_{false};
    bool closing_ = false;  // set by the loop after stopping_
    Clock::time_point acceptPausedUntil_ = Clock::time_point::max();
    Id nextId_ = 2;
    std::unordered_map<Id, Client> clients_;
    Deadlines deadlines_;
    std::mutex mutex_;
    std::vector<Message> messages_;
    WorkerPool workers_;
};

}  // namespace clerestory
