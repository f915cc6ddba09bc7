// The account of what each client holds.
#include "server/base/holdings.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <string>
#include <vector>

namespace clerestory::test {
namespace {

using Held = Holdings::Held;

std::size_t takeAll(Holdings& holdings, const std::string& client, std::vector<Held>& into) {
    std::size_t count = 0;
    for (auto held = holdings.take(Pool::streams, client, 1); held;
         held = holdings.take(Pool::streams, client, 1)) {
        into.push_back(*std::move(held));
        ++count;
    }
    return count;
}

TEST(Holdings, AClientAloneHasHalfOfAPoolAndOthersFindRoom) {
    Holdings holdings({{Pool::streams, {.most = 32}}});
    std::vector<Held> ann, ben, others;
    EXPECT_EQ(takeAll(holdings, "ann", ann), 16u);
    EXPECT_EQ(takeAll(holdings, "ben", ben), 8u);
    EXPECT_EQ(takeAll(holdings, "ann", ann), 0u);
    int clients = 2;
    while (auto held = holdings.take(Pool::streams, "client" + std::to_string(clients), 1)) {
        others.push_back(*std::move(held));
        ++clients;
    }
    EXPECT_EQ(clients, 10) << "each of eight more gets one";
    const Holdings::Usage usage = holdings.usage(Pool::streams);
    EXPECT_EQ(usage.total, 32u);
    EXPECT_EQ(usage.clients, 10u);
    EXPECT_EQ(usage.greatest, 16u);
    EXPECT_EQ(usage.greatestClient, "ann");
    ann.clear();
    others.clear();
    EXPECT_EQ(holdings.usage(Pool::streams).total, 8u);
    EXPECT_EQ(holdings.of(Pool::streams, "ben"), 8u);
    EXPECT_EQ(holdings.of(Pool::streams, "ann"), 0u);
}

TEST(Holdings, SizesAreCountedAsTheyChange) {
    Holdings holdings({{Pool::responseBytes, {.most = 100, .firstMayExceed = true}},
                       {Pool::requestBytes, {.most = 100}}});
    EXPECT_FALSE(holdings.take(Pool::requestBytes, "ann", 101)) << "strict";
    auto large = holdings.take(Pool::responseBytes, "ann", 300);
    ASSERT_TRUE(large) << "the first may exceed";
    EXPECT_FALSE(holdings.allows(Pool::responseBytes, "ben", 1)) << "full";
    EXPECT_TRUE(holdings.allows(Pool::responseBytes, "ben", 0));
    large->resize(40);
    EXPECT_TRUE(holdings.allows(Pool::responseBytes, "ben", 200));
    EXPECT_TRUE(holdings.allows(Pool::responseBytes, "ann", 10));
    EXPECT_FALSE(holdings.allows(Pool::responseBytes, "ann", 11)) << "more than is free then";
    const Held moved = *std::move(large);
    large.reset();
    EXPECT_EQ(holdings.usage(Pool::responseBytes).total, 40u) << "moved, not ended";
    EXPECT_TRUE(holdings.take(Pool::views, "ann", 1'000'000)) << "a pool without a limit";
}

// As a property: no client who holds nothing is refused while one client holds half of the pool.
TEST(Holdings, NoClientIsRefusedBecauseOfOneHeavyClient) {
    std::mt19937 random(1);
    for (int round = 0; round < 200; ++round) {
        const std::size_t most = 2 + random() % 60;
        Holdings holdings({{Pool::streams, {.most = most}}});
        std::vector<Held> held;
        for (int step = 0; step < 300; ++step) {
            const std::string client = "client" + std::to_string(random() % 6);
            if (random() % 3 == 0 && !held.empty()) {
                std::vector<Held> kept;
                const std::size_t out = random() % held.size();
                for (std::size_t i = 0; i < held.size(); ++i) {
                    if (i != out) kept.push_back(std::move(held[i]));
                }
                held.swap(kept);
                continue;
            }
            const Holdings::Usage before = holdings.usage(Pool::streams);
            const bool holdsNothing = holdings.of(Pool::streams, client) == 0;
            auto taken = holdings.take(Pool::streams, client, 1);
            if (taken) {
                held.push_back(*std::move(taken));
            } else if (holdsNothing) {
                EXPECT_EQ(before.total, most) << "refused though there was room";
                EXPECT_LE(before.greatest, (most + 1) / 2);
            }
            ASSERT_LE(holdings.usage(Pool::streams).total, most);
        }
    }
}

}  // namespace
}  // namespace clerestory::test
