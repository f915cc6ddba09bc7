// Fairness of the queue before the renderer as a property: every pairing of frame costs, and random
// populations of clients, with a simulated clock.
#include "server/queue/fair_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace clerestory::test {
namespace {

using std::chrono::milliseconds;

// How a client behaves.
struct Habits {
    int cost = 1;      // of a frame: milliseconds
    int frames = 1;    // that it requests at the same time; moderate: 1
    int pause = 0;     // after an answer, a refusal or the end of its patience: milliseconds
    int patience = 0;  // milliseconds
};

// What happened to the clients that hold one frame at a time, and to the renderer.
struct Outcome {
    int answered = 0;
    int refused = 0;           // while a client with more than one waiting frame had a place
    int expired = 0;           // not answered within their patience
    int worstForeign = 0;      // frames of heavy clients that started or ran before a frame
    double utilisation = 0.0;  // of the renderer's time

    std::string text() const {
        char line[160];
        std::snprintf(line, sizeof line,
                      "%d answered, %d refused, %d expired, %d foreign frames, %.1f %% busy",
                      answered, refused, expired, worstForeign, 100.0 * utilisation);
        return line;
    }
};

// One renderer and a population of clients; events in the order of time.
class Population {
public:
    Population(const FairQueue::Limits& limits, std::vector<Habits> clients)
        : queue_(limits), clients_(std::move(clients)) {
        for (std::size_t i = 0; i < clients_.size(); ++i) {
            for (int n = 0; n < clients_[i].frames; ++n) wishes_.insert({milliseconds(0), i});
        }
    }

    Outcome run(milliseconds time) {
        while (now_ < time) {
            while (!wishes_.empty() && wishes_.begin()->first <= now_) {
                const std::size_t client = wishes_.begin()->second;
                wishes_.erase(wishes_.begin());
                ask(client);
            }
            if (!running_) start();
            auto next = running_ ? ends_ : time;
            if (!wishes_.empty()) next = std::min(next, wishes_.begin()->first);
            next = std::max(next, now_);
            if (running_) busy_ += next - now_;
            now_ = next;
            if (running_ && ends_ <= now_) finish();
        }
        outcome_.utilisation =
            static_cast<double>(busy_.count()) / static_cast<double>(now_.count());
        return outcome_;
    }

private:
    struct Frame {
        std::size_t client = 0;
        int heavyBefore = 0;
    };

    static std::string nameOf(std::size_t client) { return "client" + std::to_string(client); }
    bool isModerate(std::size_t client) const { return clients_[client].frames == 1; }
    Clock::time_point clock() const { return Clock::time_point(now_); }
    void askAgain(std::size_t client) {
        wishes_.insert({now_ + milliseconds(std::max(clients_[client].pause, 1)), client});
    }

    void ask(std::size_t client) {
        const Habits& habits = clients_[client];
        const FairQueue::Added added =
            queue_.add({nameOf(client), static_cast<std::uint64_t>(habits.cost),
                        clock() + milliseconds(habits.patience)},
                       clock());
        for (const FairQueue::Id out : added.evicted) {
            outcome_.refused += isModerate(waiting_.at(out).client);
            askAgain(waiting_.at(out).client);
            waiting_.erase(out);
        }
        if (added.id) {
            const bool foreign = running_ && !isModerate(runs_.client) && runs_.client != client;
            waiting_[*added.id] = {client, foreign ? 1 : 0};
            return;
        }
        askAgain(client);
        if (!isModerate(client)) return;
        std::map<std::size_t, int> held;
        for (const auto& [id, frame] : waiting_) ++held[frame.client];
        outcome_.refused +=
            std::any_of(held.begin(), held.end(), [](const auto& one) { return one.second > 1; });
    }

    void start() {
        const FairQueue::Next next = queue_.next(clock());
        for (const FairQueue::Id late : next.expired) {
            outcome_.expired += isModerate(waiting_.at(late).client);
            askAgain(waiting_.at(late).client);
            waiting_.erase(late);
        }
        if (!next.id) return;
        running_ = next.id;
        runs_ = waiting_.at(*next.id);
        waiting_.erase(*next.id);
        ends_ = now_ + milliseconds(clients_[runs_.client].cost);
        if (isModerate(runs_.client)) {
            ++outcome_.answered;
            outcome_.worstForeign = std::max(outcome_.worstForeign, runs_.heavyBefore);
            return;
        }
        for (auto& [id, frame] : waiting_) frame.heavyBefore += frame.client != runs_.client;
    }

    void finish() {
        queue_.finished(*running_, clock());
        askAgain(runs_.client);
        running_.reset();
    }

    FairQueue queue_;
    const std::vector<Habits> clients_;
    std::multiset<std::pair<milliseconds, std::size_t>> wishes_;
    std::map<FairQueue::Id, Frame> waiting_;
    std::optional<FairQueue::Id> running_;
    Frame runs_;
    milliseconds now_{0}, ends_{0}, busy_{0};
    Outcome outcome_;
};

// A2 of the catalogue of attacks: 24 connections of cheap frames left no room for expensive ones.
TEST(Fairness, AModerateClientWaitsForTwoFramesOfAFloodWhateverTheFramesCost) {
    int worst = 0;
    for (const int moderate : {1, 3, 10, 30, 100, 190, 300, 1000}) {
        for (const int flood : {1, 2, 3, 10, 30, 100, 300, 1000}) {
            for (const int pause : {1, 1000}) {
                Population population(
                    {.count = 16, .seconds = 2.0},
                    {{.cost = moderate, .frames = 1, .pause = pause, .patience = 10000},
                     {.cost = flood, .frames = 24, .pause = 12, .patience = 10000}});
                const Outcome outcome = population.run(milliseconds(20000));
                const std::string words = std::to_string(moderate) + " ms next to " +
                                          std::to_string(flood) + " ms: " + outcome.text();
                EXPECT_GE(outcome.answered, 5) << words;
                EXPECT_EQ(outcome.refused, 0) << words;
                EXPECT_EQ(outcome.expired, 0) << words;
                EXPECT_LE(outcome.worstForeign, 2) << words;
                EXPECT_GT(outcome.utilisation, 0.95) << words;
                worst = std::max(worst, outcome.worstForeign);
            }
        }
    }
    std::printf("the longest wait: %d foreign frames\n", worst);
}

TEST(Fairness, HoldsForRandomPopulations) {
    std::mt19937 random(1);
    const auto between = [&](int least, int most) {
        return std::uniform_int_distribution(least, most)(random);
    };
    const auto cost = [&] {
        return static_cast<int>(
            std::lround(std::pow(10.0, std::uniform_real_distribution(0.0, 3.0)(random))));
    };
    Outcome worst{.utilisation = 1.0};
    for (int i = 0; i < 100; ++i) {
        std::vector<Habits> clients;
        for (int n = between(1, 6); n > 0; --n) {
            clients.push_back({.cost = cost(),
                               .frames = 1,
                               .pause = between(1, 2000),
                               .patience = between(15000, 60000)});
        }
        for (int n = between(1, 4); n > 0; --n) {
            clients.push_back({.cost = cost(),
                               .frames = between(8, 40),
                               .pause = between(2, 6),
                               .patience = between(2000, 20000)});
        }
        std::shuffle(clients.begin(), clients.end(), random);
        Population population({.count = 16, .seconds = 2.0}, clients);
        const Outcome outcome = population.run(milliseconds(12000));
        const std::string words = "population " + std::to_string(i) + ": " + outcome.text();
        EXPECT_GT(outcome.answered, 0) << words;
        EXPECT_EQ(outcome.refused, 0) << words;
        EXPECT_EQ(outcome.expired, 0) << words;
        EXPECT_LE(outcome.worstForeign, 2) << words;
        EXPECT_GT(outcome.utilisation, 0.95) << words;
        worst.answered += outcome.answered;
        worst.worstForeign = std::max(worst.worstForeign, outcome.worstForeign);
        worst.utilisation = std::min(worst.utilisation, outcome.utilisation);
    }
    std::printf("the worst of 100 populations: %s\n", worst.text().c_str());
}

}  // namespace
}  // namespace clerestory::test
