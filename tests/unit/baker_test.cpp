// When the light of scenes is computed: not while frames are drawn.
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

}  // namespace
}  // namespace clerestory::light
