// Who waits for the one thread that draws, and whose turn it is. The line is bounded by count and
// by predicted time; clients take turns by the time they have had, so that a greedy one waits
// behind itself; where there is no room, the greediest gives way.
//
// Does not: know threads or read a clock: time is an argument.
#pragma once

#include "server/base/clock.h"

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace clerestory {

// How long each kind of work took lately.
class CostBook {
public:
    double predicted(std::uint64_t kind) const;  // seconds
    void learn(std::uint64_t kind, double seconds);

private:
    struct Cost {
        double seconds = 0.0;
        bool warm = false;  // the first time made maps and programs too
    };
    std::unordered_map<std::uint64_t, Cost> costs_;
    double mean_ = 0.05;  // of whatever comes
};

class FairQueue {
public:
    using Id = std::uint64_t;
    struct Limits {
        std::size_t count = 16;  // that may wait
        double seconds = 2.0;    // of predicted work that may wait; one always may
    };
    struct Ticket {
        std::string client;
        std::uint64_t kind = 0;  // equal kinds take about the same time
        Clock::time_point deadline = Clock::time_point::max();
    };

    explicit FairQueue(const Limits& limits) : limits_(limits) {}

    struct Entry {
        std::optional<Id> id;       // none: refused
        std::vector<Id> pushedOut;  // that must be told so
    };
    // Refuses what finds no room, and what could not begin before its deadline.
    Entry enter(const Ticket& ticket, Clock::time_point now);

    // Whether enter() would surely refuse this client.
    bool refuses(const std::string& client) const;

    struct Turn {
        std::optional<Id> id;  // begins now; none: nobody waits
        std::vector<Id> late;  // past their deadlines, and gone
    };
    Turn next(Clock::time_point now);
    void finished(Clock::time_point now);  // what next() began

    bool leave(Id id);  // false: it does not wait any more

    std::size_t waiting() const { return tickets_.size(); }
    double waitingSeconds() const { return waitingSeconds_; }  // predicted
    bool hasRoom() const;

private:
    struct Waiting {
        Ticket ticket;
        double seconds = 0.0;  // predicted
    };
    struct Line {
        std::deque<Id> ids;
        double held = 0.0;  // predicted seconds of those that wait
        double had = 0.0;   // seconds, on the scale of had_
    };
    using Lines = std::map<std::string, Line>;

    double heldBy(const std::string& client) const;
    Lines::const_iterator greediest() const;
    Waiting take(Id id);
    double remaining(Clock::time_point now) const;
    void forgetQuietLines();

    const Limits limits_;
    CostBook costs_;
    Id nextId_ = 1;
    std::unordered_map<Id, Waiting> tickets_;
    Lines lines_;
    double waitingSeconds_ = 0.0;
    double had_ = 0.0;  // what the client whose turn it was has had: who comes anew begins there
    std::optional<Waiting> running_;
    Clock::time_point began_{};
};

}  // namespace clerestory
