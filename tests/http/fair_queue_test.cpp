// The queue before the renderer, with a simulated clock.
#include "server/queue/fair_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace clerestory::test {
namespace {

using std::chrono::milliseconds;

// A line, a clock, and one who works it off; every piece takes as long as its kind says in ms.
class Shop {
public:
    explicit Shop(FairQueue::Limits limits) : line_(limits) {}

    std::optional<FairQueue::Id> enter(const std::string& client, int ms, int patienceMs = 100000) {
        const FairQueue::Added entry = line_.add(
            {client, static_cast<std::uint64_t>(ms), now_ + milliseconds(patienceMs)}, now_);
        for (const FairQueue::Id out : entry.evicted) pushedOut.push_back(clients_.at(out));
        if (entry.id) {
            clients_[*entry.id] = client;
            times_[*entry.id] = {ms, now_, now_ + milliseconds(patienceMs)};
        }
        return entry.id;
    }

    // The client that was served; empty if the queue is empty.
    std::string serve() {
        const FairQueue::Next turn = line_.next(now_);
        late += static_cast<int>(turn.expired.size());
        if (!turn.id) return "";
        const Times& times = times_.at(*turn.id);
        waits[clients_.at(*turn.id)].push_back(
            std::chrono::duration<double>(now_ - times.entered).count());
        begunLate += now_ >= times.deadline;
        now_ += milliseconds(times.ms);
        line_.finished(now_);
        return clients_.at(*turn.id);
    }

    void pass(int ms) { now_ += milliseconds(ms); }
    FairQueue& line() { return line_; }

    std::vector<std::string> pushedOut;
    std::map<std::string, std::vector<double>> waits;  // seconds in the line
    int late = 0, begunLate = 0;

private:
    struct Times {
        int ms = 0;
        Clock::time_point entered, deadline;
    };
    FairQueue line_;
    Clock::time_point now_{};
    std::map<FairQueue::Id, std::string> clients_;
    std::map<FairQueue::Id, Times> times_;
};

TEST(FairQueue, TheNumberOfFramesIsBounded) {
    Shop shop({.count = 4, .seconds = 100});
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(shop.enter("a", 10)) << i;
    EXPECT_TRUE(shop.line().refuses("a"));
    EXPECT_FALSE(shop.enter("a", 10));
    EXPECT_EQ(shop.serve(), "a");
    EXPECT_FALSE(shop.line().refuses("a"));
    EXPECT_TRUE(shop.enter("a", 10));
}

TEST(FairQueue, PredictedTimeIsBoundedButOneFrameIsAlwaysAccepted) {
    Shop shop({.count = 100, .seconds = 1.0});
    for (int i = 0; i < 6; ++i) {  // learns that this kind takes 400 ms
        ASSERT_TRUE(shop.enter("a", 400));
        shop.serve();
    }
    EXPECT_TRUE(shop.enter("a", 400));
    EXPECT_TRUE(shop.enter("a", 400));
    EXPECT_FALSE(shop.enter("a", 400));
    Shop slow({.count = 100, .seconds = 1.0});
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(slow.enter("a", 5000))
            << "one frame is always accepted, or predictions would never be corrected";
        slow.serve();
    }
}

TEST(FairQueue, ClientsAreServedInTurn) {
    Shop shop({.count = 16, .seconds = 100});
    for (int i = 0; i < 8; ++i) shop.enter("heavy", 100);
    EXPECT_EQ(shop.serve(), "heavy");
    shop.enter("light", 100);
    EXPECT_EQ(shop.serve(), "light") << "clients without a frame come first";
    EXPECT_EQ(shop.serve(), "heavy");
}

TEST(FairQueue, WhenFullTheHeaviestClientLosesItsFrame) {
    Shop shop({.count = 4, .seconds = 100});
    for (int i = 0; i < 4; ++i) shop.enter("heavy", 100);
    EXPECT_FALSE(shop.line().refuses("light"));
    EXPECT_TRUE(shop.enter("light", 100));
    EXPECT_EQ(shop.pushedOut, std::vector<std::string>{"heavy"});
    EXPECT_TRUE(shop.enter("light", 100));
    EXPECT_FALSE(shop.enter("light", 100)) << "both hold the same now";
    EXPECT_FALSE(shop.enter("heavy", 100));
}

// L3 of the failure catalogue: one floods, three ask once in a while.
TEST(FairQueue, AWellBehavedClientWaitsForAtMostOneFrameOfAFlood) {
    constexpr int kMs = 20;
    Shop shop({.count = 16, .seconds = 2});
    for (int i = 0; i < 3000; ++i) {
        while (shop.enter("heavy", kMs)) {
        }
        if (i % 10 == 0) shop.enter("light" + std::to_string(i / 10 % 3), kMs);
        shop.serve();
    }
    for (const char* name : {"light0", "light1", "light2"}) {
        auto& waits = shop.waits[name];
        EXPECT_EQ(waits.size(), 100u) << "none was refused";
        std::sort(waits.begin(), waits.end());
        EXPECT_LE(waits[98], 2 * kMs / 1000.0);
    }
}

// L4: for any sequence of events, no frame starts after its deadline.
TEST(FairQueue, FramesPastTheirDeadlineDoNotStart) {
    std::mt19937 random(7);
    Shop shop({.count = 16, .seconds = 100});
    int entered = 0;
    for (int i = 0; i < 20000; ++i) {
        entered += shop.enter("client" + std::to_string(random() % 5),
                              5 + static_cast<int>(random() % 40), static_cast<int>(random() % 300))
                       .has_value();
        if (random() % 3 == 0) shop.serve();
        shop.pass(static_cast<int>(random() % 10));
    }
    EXPECT_EQ(shop.begunLate, 0);
    EXPECT_GT(shop.late, 0) << "some had to be dropped";
    EXPECT_GT(entered, 1000);
}

TEST(FairQueue, FramesThatCannotMeetTheirDeadlineAreRejectedImmediately) {
    Shop shop({.count = 16, .seconds = 100});
    for (int i = 0; i < 6; ++i) {
        shop.enter("a", 100);
        shop.serve();
    }
    EXPECT_TRUE(shop.enter("a", 100));
    EXPECT_TRUE(shop.enter("a", 100));
    EXPECT_FALSE(shop.enter("a", 100, 150)) << "200 ms of its own wait before it";
    EXPECT_FALSE(shop.enter("b", 100, 0));
}

TEST(FairQueue, LeavingClientsFreeTheirPlace) {
    Shop shop({.count = 2, .seconds = 100});
    const auto first = shop.enter("a", 10);
    shop.enter("a", 10);
    EXPECT_FALSE(shop.enter("a", 10));
    EXPECT_TRUE(shop.line().remove(*first));
    EXPECT_FALSE(shop.line().remove(*first));
    EXPECT_EQ(shop.line().waiting(), 1u);
    EXPECT_TRUE(shop.enter("a", 10));
    shop.serve();
    shop.serve();
    EXPECT_EQ(shop.serve(), "");
    EXPECT_EQ(shop.line().waitingSeconds(), 0.0);
}

}  // namespace
}  // namespace clerestory::test
