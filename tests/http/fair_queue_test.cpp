// The queue before the renderer, with a simulated clock.
#include "server/queue/fair_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace clerestory::test {
namespace {

using std::chrono::milliseconds;

// A queue with a simulated clock and one consumer; each frame takes `ms` milliseconds.
class QueueSimulation {
public:
    explicit QueueSimulation(FairQueue::Limits limits) : queue_(limits) {}

    std::optional<FairQueue::Id> enter(const std::string& client, int ms, int timeoutMs = 100000) {
        const FairQueue::Added entry = queue_.add(
            {client, static_cast<std::uint64_t>(ms), now_ + milliseconds(timeoutMs)}, now_);
        for (const FairQueue::Id out : entry.evicted) evicted.push_back(clients_.at(out));
        if (entry.id) {
            clients_[*entry.id] = client;
            times_[*entry.id] = {ms, now_, now_ + milliseconds(timeoutMs)};
        }
        return entry.id;
    }

    // The client that was served; empty if the queue is empty.
    std::string serve() {
        const FairQueue::Next turn = queue_.next(now_);
        late += static_cast<int>(turn.expired.size());
        if (!turn.id) return "";
        const Times& times = times_.at(*turn.id);
        waits[clients_.at(*turn.id)].push_back(
            std::chrono::duration<double>(now_ - times.entered).count());
        startedLate += now_ >= times.deadline;
        now_ += milliseconds(times.ms);
        queue_.finished(*turn.id, now_);
        return clients_.at(*turn.id);
    }

    void advance(int ms) { now_ += milliseconds(ms); }
    FairQueue& queue() { return queue_; }

    std::vector<std::string> evicted;
    std::map<std::string, std::vector<double>> waits;  // seconds in the queue
    int late = 0, startedLate = 0;

private:
    struct Times {
        int ms = 0;
        Clock::time_point entered, deadline;
    };
    FairQueue queue_;
    Clock::time_point now_{};
    std::map<FairQueue::Id, std::string> clients_;
    std::map<FairQueue::Id, Times> times_;
};

TEST(FairQueue, TheNumberOfFramesIsBounded) {
    QueueSimulation simulation({.count = 4, .seconds = 100});
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(simulation.enter("a", 10)) << i;
    EXPECT_TRUE(simulation.queue().refuses("a"));
    EXPECT_FALSE(simulation.enter("a", 10));
    EXPECT_EQ(simulation.serve(), "a");
    EXPECT_FALSE(simulation.queue().refuses("a"));
    EXPECT_TRUE(simulation.enter("a", 10));
}

TEST(FairQueue, PredictedTimeIsBoundedButOneFrameIsAlwaysAccepted) {
    QueueSimulation simulation({.count = 100, .seconds = 1.0});
    for (int i = 0; i < 6; ++i) {  // learns that this kind takes 400 ms
        ASSERT_TRUE(simulation.enter("a", 400));
        simulation.serve();
    }
    EXPECT_TRUE(simulation.enter("a", 400));
    EXPECT_TRUE(simulation.enter("a", 400));
    EXPECT_FALSE(simulation.enter("a", 400));
    QueueSimulation slow({.count = 100, .seconds = 1.0});
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(slow.enter("a", 5000))
            << "one frame is always accepted, or predictions would never be corrected";
        slow.serve();
    }
}

TEST(FairQueue, ClientsAreServedInTurn) {
    QueueSimulation simulation({.count = 16, .seconds = 100});
    for (int i = 0; i < 8; ++i) simulation.enter("heavy", 100);
    EXPECT_EQ(simulation.serve(), "heavy");
    simulation.enter("light", 100);
    EXPECT_EQ(simulation.serve(), "light") << "clients without a frame come first";
    EXPECT_EQ(simulation.serve(), "heavy");
}

TEST(FairQueue, WhenFullTheHeaviestClientLosesItsFrame) {
    QueueSimulation simulation({.count = 4, .seconds = 100});
    for (int i = 0; i < 4; ++i) simulation.enter("heavy", 100);
    EXPECT_FALSE(simulation.queue().refuses("light"));
    EXPECT_TRUE(simulation.enter("light", 100));
    EXPECT_EQ(simulation.evicted, std::vector<std::string>{"heavy"});
    EXPECT_TRUE(simulation.enter("light", 100));
    EXPECT_FALSE(simulation.enter("light", 100)) << "both hold the same now";
    EXPECT_FALSE(simulation.enter("heavy", 100));
}

TEST(FairQueue, SeveralServersWorkAtTheSameTime) {
    FairQueue queue({.count = 8, .seconds = 1.0, .servers = 2});
    const Clock::time_point now{};
    const auto enter = [&](const char* client, std::uint64_t kind) {
        return queue.add({client, kind, now + milliseconds(100000)}, now).id;
    };
    const auto a = enter("a", 1), b = enter("a", 1), c = enter("b", 2);
    ASSERT_TRUE(a && b && c);
    // Not the entry of the other client, which may not start yet.
    EXPECT_EQ(queue.next(now, [&](FairQueue::Id id) { return id == *b; }).id, b);
    EXPECT_FALSE(queue.next(now, [](FairQueue::Id) { return false; }).id);
    EXPECT_EQ(queue.next(now).id, c) << "this client has used less";
    EXPECT_EQ(queue.waiting(), 1u);
    queue.finished(*b, now + milliseconds(2000));
    queue.finished(*c, now + milliseconds(10));
    EXPECT_EQ(queue.next(now).id, a);
    queue.finished(*a, now + milliseconds(2000));

    // Each server may have a second of waiting work: kind 1 takes two, kind 2 next to nothing.
    EXPECT_TRUE(enter("a", 1)) << "one always waits";
    EXPECT_DOUBLE_EQ(queue.waitingSeconds(), 1.0);
    EXPECT_FALSE(queue.hasRoom());
    EXPECT_FALSE(enter("a", 1)) << "the limit applies to a client's second entry";
    EXPECT_TRUE(enter("b", 2)) << "but not to the first one of another client";
    EXPECT_EQ(queue.waiting(), 2u) << "and the heavy client keeps its only entry";
    EXPECT_FALSE(enter("b", 2));
}

// L3 of the failure catalogue: one floods, three ask once in a while.
TEST(FairQueue, AWellBehavedClientWaitsForAtMostOneFrameOfAFlood) {
    constexpr int kMs = 20;
    QueueSimulation simulation({.count = 16, .seconds = 2});
    for (int i = 0; i < 3000; ++i) {
        while (simulation.enter("heavy", kMs)) {
        }
        if (i % 10 == 0) simulation.enter("light" + std::to_string(i / 10 % 3), kMs);
        simulation.serve();
    }
    for (const char* name : {"light0", "light1", "light2"}) {
        auto& waits = simulation.waits[name];
        EXPECT_EQ(waits.size(), 100u) << "none was refused";
        std::sort(waits.begin(), waits.end());
        EXPECT_LE(waits[98], 2 * kMs / 1000.0);
    }
}

// L4: for any sequence of events, no frame starts after its deadline.
TEST(FairQueue, FramesPastTheirDeadlineDoNotStart) {
    std::mt19937 random(7);
    QueueSimulation simulation({.count = 16, .seconds = 100});
    int entered = 0;
    for (int i = 0; i < 20000; ++i) {
        entered += simulation
                       .enter("client" + std::to_string(random() % 5),
                              5 + static_cast<int>(random() % 40), static_cast<int>(random() % 300))
                       .has_value();
        if (random() % 3 == 0) simulation.serve();
        simulation.advance(static_cast<int>(random() % 10));
    }
    EXPECT_EQ(simulation.startedLate, 0);
    EXPECT_GT(simulation.late, 0) << "some had to be dropped";
    EXPECT_GT(entered, 1000);
}

TEST(FairQueue, FramesThatCannotMeetTheirDeadlineAreRejectedImmediately) {
    QueueSimulation simulation({.count = 16, .seconds = 100});
    for (int i = 0; i < 6; ++i) {
        simulation.enter("a", 100);
        simulation.serve();
    }
    EXPECT_TRUE(simulation.enter("a", 100));
    EXPECT_TRUE(simulation.enter("a", 100));
    EXPECT_FALSE(simulation.enter("a", 100, 150)) << "200 ms of its own wait before it";
    EXPECT_FALSE(simulation.enter("b", 100, 0));
}

TEST(FairQueue, WorkThatEndedEarlySaysNothingAboutItsKind) {
    FairQueue queue({.count = 16, .seconds = 100.0});
    Clock::time_point now{};
    const auto work = [&](milliseconds time, bool complete) {
        const FairQueue::Id id = *queue.add({.client = "ann", .kind = 1}, now).id;
        queue.next(now);
        now += time;
        queue.finished(id, now, complete);
    };
    for (int i = 0; i < 8; ++i) work(milliseconds(500), true);
    for (int i = 0; i < 8; ++i) work(milliseconds(1), false);
    queue.add({.client = "ann", .kind = 1}, now);
    EXPECT_NEAR(queue.waitingSeconds(), 0.5, 0.05);
}

TEST(FairQueue, LeavingClientsFreeTheirPlace) {
    QueueSimulation simulation({.count = 2, .seconds = 100});
    const auto first = simulation.enter("a", 10);
    simulation.enter("a", 10);
    EXPECT_FALSE(simulation.enter("a", 10));
    EXPECT_TRUE(simulation.queue().remove(*first));
    EXPECT_FALSE(simulation.queue().remove(*first));
    EXPECT_EQ(simulation.queue().waiting(), 1u);
    EXPECT_TRUE(simulation.enter("a", 10));
    simulation.serve();
    simulation.serve();
    EXPECT_EQ(simulation.serve(), "");
    EXPECT_EQ(simulation.queue().waitingSeconds(), 0.0);
}

}  // namespace
}  // namespace clerestory::test
