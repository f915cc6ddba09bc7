// The order in which clients use the threads or processes that draw: one, or several equal ones.
// The queue is limited in number and in predicted time. The client that has used the least time is
// next, so that a heavy client delays only itself. If the queue is full, the client with the most
// waiting work loses its last entry.
//
// A value without threads and clock: the time is an argument.
#pragma once

#include "server/base/process.h"

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace clerestory {

// Predicts the time of work from the recent times of its kind.
class CostPredictor {
public:
    double predict(std::uint64_t kind) const;  // seconds
    void update(std::uint64_t kind, double seconds);

private:
    struct Cost {
        double seconds = 0.0;
        bool warm = false;  // the first time of a kind includes maps and programs
    };
    std::unordered_map<std::uint64_t, Cost> costs_;
    double mean_ = 0.05;  // of all kinds
};

class FairQueue {
public:
    using Id = std::uint64_t;
    struct Limits {
        std::size_t count = 16;  // of waiting entries
        // Of predicted work that waits, for each server; one entry may always wait.
        double seconds = 2.0;
        std::size_t servers = 1;  // that work at the same time
    };
    struct Ticket {
        std::string client;
        std::uint64_t kind = 0;  // work of one kind takes about the same time
        Clock::time_point deadline = Clock::time_point::max();
    };

    explicit FairQueue(const Limits& limits) : limits_(limits) {}

    struct Added {
        std::optional<Id> id;     // empty: refused
        std::vector<Id> evicted;  // removed to make room
    };
    // Refuses work for which there is no room, or which could not start before its deadline.
    Added add(const Ticket& ticket, Clock::time_point now);

    // Whether add() would certainly refuse this client.
    bool refuses(const std::string& client) const;

    struct Next {
        std::optional<Id> id;     // starts now; empty: nothing waits
        std::vector<Id> expired;  // removed because their deadlines have passed
    };
    // mayStart: whether a waiting entry may start now; empty: all may.
    Next next(Clock::time_point now, const std::function<bool(Id)>& mayStart = {});
    // Work that next() started has ended. Its time is what work of its kind takes if it is
    // complete.
    void finished(Id id, Clock::time_point now, bool complete = true);

    bool remove(Id id);  // returns false if it does not wait any more

    std::size_t waiting() const { return tickets_.size(); }
    // Predicted time until all that waits has started.
    double waitingSeconds() const { return waitingSeconds_ / servers(); }
    bool hasRoom() const;
    // How long a client without a place should wait: half of the waiting work, 1 to 60 seconds.
    int retryAfterSeconds() const;

private:
    struct Waiting {
        Ticket ticket;
        double seconds = 0.0;  // predicted
    };
    struct ClientQueue {
        std::deque<Id> ids;
        double waitingSeconds = 0.0;  // predicted
        double usedSeconds = 0.0;     // comparable with usedSeconds_
    };
    using ClientQueues = std::map<std::string, ClientQueue>;
    struct Running {
        Waiting work;
        Clock::time_point began;
    };

    double servers() const { return static_cast<double>(limits_.servers); }
    double waitingSecondsOf(const std::string& client) const;
    ClientQueues::const_iterator heaviestClient() const;
    Waiting take(Id id);
    double remaining(Clock::time_point now) const;
    void removeIdleClients();

    const Limits limits_;
    CostPredictor costs_;
    Id nextId_ = 1;
    std::unordered_map<Id, Waiting> tickets_;
    ClientQueues clients_;
    double waitingSeconds_ = 0.0;
    double usedSeconds_ = 0.0;  // of the client that was served last; a new client starts with it
    std::unordered_map<Id, Running> running_;
};

}  // namespace clerestory
