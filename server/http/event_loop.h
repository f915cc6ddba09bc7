// One thread, every connection: accepts, reads whole requests within the limits, hands them to
// workers, sends what they answered, and gives up on whoever is too slow.
//
// Does not: know routes; wait for anybody.
#pragma once

#include "server/http/counters.h"
#include "server/http/deadlines.h"
#include "server/http/exchange.h"
#include "server/http/listener.h"
#include "server/http/request_reader.h"
#include "server/http/response_writer.h"
#include "server/http/worker_pool.h"

#include <unordered_map>

namespace clerestory {

class EventLoop {
public:
    struct Hooks {
        // Whom a request from that address counts for.
        std::function<std::string(const RequestHead&, const std::string& address)> client;
        // On the loop's thread, so they must not wait: the answer to what needs no worker, if it is
        // such; and the answer to what HTTP rules out.
        std::function<std::optional<Answer>(const Exchange&)> quick;
        // Why a large body need not come at all.
        std::function<std::optional<Problem>(const RequestHead&)> admit;
        std::function<Answer(const Call&, const Problem&)> refuse;
        // On a worker's thread; true when the connection may carry another. Must not throw.
        std::function<bool(Exchange&, ResponseWriter&)> answer;
    };

    EventLoop(Listener& listener, const FrontLimits& limits, std::size_t threads, Hooks hooks,
              FrontCounters& counters);
    ~EventLoop();
    EventLoop(const EventLoop&) = delete;
    EventLoop& operator=(const EventLoop&) = delete;

    void run();   // until stop(), and then until everybody has an answer
    void stop();  // from any thread

private:
    using Id = Deadlines::Id;
    enum class Phase {
        reading,   // a request, or waiting for one
        serving,   // a worker has it
        flushing,  // the answer is given and not yet taken
        draining,  // the end was told; what still comes is thrown away
    };
    // What a connection is given time for.
    enum class Wait { nothing, idle, head, body, write, drain };
    struct Client {
        std::shared_ptr<SocketWriter> writer;
        RequestReader reader;
        std::string address;
        std::shared_ptr<CancellationToken> cancellation;  // of the exchange that is served
        Phase phase = Phase::reading;
        Wait wait = Wait::nothing;
        std::uint64_t moved = 0;  // bytes of what is waited for, at the last progress
        std::size_t large = 0;    // of largeBodies_: its own
        std::uint32_t interest = 0;
        bool watched = false;
        bool halfClosed = false;
        bool keepAlive = true;
        bool told = false;  // 100 Continue
        std::size_t drained = 0;
    };
    struct Letter {  // of a worker to the loop
        Id id = 0;
        bool answered = false;  // otherwise: there is something to send
        bool keepAlive = false;
    };

    void post(const Letter& letter);
    void readLetters();
    void readLetter(const Letter& letter, Client& client);
    void handle(Id id, std::uint32_t events, Client& client);
    // Calls `act` on the client, if it is still there; an exception costs it the connection.
    template <class Act>
    void with(Id id, Act act);
    void accept(int most);
    void welcome(Listener::Accepted& accepted);
    void turnAway(SocketWriter& writer);
    bool evict(std::chrono::milliseconds youngest);
    void pauseAccepting(int error);
    void read(Id id, Client& client);
    void advance(Id id, Client& client);
    void begin(Id id, Client& client);
    void reply(Client& client, const Answer& answer, const std::string& requestId, bool isHead);
    void refuse(Client& client, const Problem& problem);
    std::optional<Problem> refusalOfBody(Client& client);
    void answered(Client& client);
    void flushed(Id id, Client& client);
    void drain(Id id, Client& client);
    void left(Client& client);
    void expire();
    void expired(Id id, Client& client);
    void beginStopping();
    void watch(Id id, Client& client);
    Wait waitOf(const Client& client) const;
    std::chrono::milliseconds timeFor(Wait wait) const;
    void updateDeadline(Id id, Client& client);
    void end(Id id);
    int millisecondsToNext() const;

    Listener& listener_;
    const FrontLimits limits_;
    const Hooks hooks_;
    FrontCounters& counters_;
    UnsentBytes unsent_;
    std::size_t largeBodies_ = 0;  // bytes, coming or being answered
    int epoll_ = -1;
    int wake_ = -1;
    std::atomic<bool> stopping_{false};
    bool closing_ = false;  // the loop has seen stopping_
    Clock::time_point acceptAgain_ = Clock::time_point::max();
    Id nextId_ = 2;
    std::unordered_map<Id, Client> clients_;
    Deadlines deadlines_;
    std::mutex mutex_;
    std::vector<Letter> letters_;
    WorkerPool workers_;  // ends first: its work writes letters
};

}  // namespace clerestory
