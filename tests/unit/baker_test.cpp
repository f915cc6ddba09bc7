// Which lights are computed, and when.
#include "light/baker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>

namespace clerestory::light {
namespace {

// The preparation takes as long as many rounds, so it must not compete with the first frame.
TEST(Baker, PreparesNothingWhileAFrameIsDrawn) {
    Baker baker({.threads = 1});
    std::atomic<bool> drawing{true};
    std::optional<Baker::Rest> rest(baker);
    bool competed = false;
    baker.begin(1, [&]() -> std::unique_ptr<Bake> {
        competed = drawing;
        throw std::runtime_error("prepared");
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_EQ(baker.state(1).failure, "");
    drawing = false;
    rest.reset();
    EXPECT_EQ(baker.wait(1).failure, "prepared");
    EXPECT_FALSE(competed);
}

// Clients of many scenes in turn: what one of them began is not lost because of the others.
TEST(Baker, ComputesMoreLightsThanItKeeps) {
    Baker baker({.threads = 1, .kept = 2, .waiting = 4});
    std::atomic<int> prepared{0};
    const auto fails = [&]() -> std::unique_ptr<Bake> {
        ++prepared;
        throw std::runtime_error("prepared");
    };
    std::optional<Baker::Rest> rest(baker);
    baker.begin(1, fails);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));  // a thread may have chosen it
    for (const std::uint64_t key : {2, 3, 4, 5}) baker.begin(key, fails);
    EXPECT_FALSE(baker.state(1).known);
    for (const std::uint64_t key : {2, 3, 4, 5}) EXPECT_TRUE(baker.state(key).known) << key;
    rest.reset();
    EXPECT_EQ(baker.wait(2).failure, "prepared");
    EXPECT_EQ(prepared, 4);
    EXPECT_TRUE(baker.state(3).known);
    for (const std::uint64_t key : {4, 5}) EXPECT_FALSE(baker.state(key).known) << key;
}

}  // namespace
}  // namespace clerestory::light
