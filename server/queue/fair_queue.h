// The order in which clients use the threads or processes that draw: one, or several equal ones.
// The client that has used the least time is next, so that a heavy client delays only itself. A
// client that holds one entry at a time (for a second) waits for at most two entries of clients
// that hold more: the one that runs, and one more, whatever their times are.
//
// The queue is limited in number and in predicted time. The limit of time applies to a client's
// second and further entries only, so that the cost of its frames excludes no client. If the queue
// is full, the client with the largest share of it, by number or by time, loses its last entry, but
// never its only one.
//
// A value without threads and clock: the time is an argument.
//
//     FairQueue queue({.count = 16, .seconds = 2.0});
//     const FairQueue::Added added = queue.add({.client = "192.0.2.7", .kind = 3}, now);
//     const FairQueue::Next next = queue.next(now);
//     queue.finished(*next.id, later);
#pragma once

#include "server/base/holdings.h"
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

// What clients have waiting in a queue: entries, and their predicted time.
struct QueueUsage {
    Holdings::Usage entries, milliseconds;
};

class FairQueue {
public:
    using Id = std::uint64_t;
    struct Limits {
        std::size_t count = 16;  // of waiting entries
        // Of predicted work that waits, for each server; one entry of each client may always wait.
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
    QueueUsage usage() const;
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
        std::size_t running = 0;      // entries
        std::size_t passed = 0;       // entries of others that started before its first one
        Clock::time_point lastHeldTwo = Clock::time_point::min();  // or wanted to
    };
    using ClientQueues = std::map<std::string, ClientQueue>;
    struct Running {
        Waiting work;
        Clock::time_point began;
    };

    double servers() const { return static_cast<double>(limits_.servers); }
    const ClientQueue* clientNamed(const std::string& name) const;
    // Of the queue, by number or by time, whichever is larger; 1: all of it.
    double share(std::size_t count, double seconds) const;
    // The client with the largest share of those that have more than one waiting entry.
    ClientQueues::const_iterator heaviestClient() const;
    bool fits(const ClientQueue* client, double seconds) const;
    bool isUrgent(const ClientQueue& client, Clock::time_point now) const;
    bool isBefore(const ClientQueue& a, const ClientQueue& b, Clock::time_point now) const;
    void countPassed(const std::string& started);
    Waiting take(Id id);
    double remaining(Clock::time_point now) const;
    double onlyEntriesSeconds() const;
    void removeIdleClients();

    const Limits limits_;
    CostPredictor costs_;
    Id nextId_ = 1;
    std::unordered_map<Id, Waiting> tickets_;
    ClientQueues clients_;
    double waitingSeconds_ = 0.0;
    double usedSeconds_ = 0.0;  // the least of a waiting client; a new client starts with it
    std::unordered_map<Id, Running> running_;
};

}  // namespace clerestory
