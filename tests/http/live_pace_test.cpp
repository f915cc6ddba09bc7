// The ladder of live frames and the choice of its levels, as pure functions of milliseconds.
#include "server/live/ladder.h"
#include "server/live/pace.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace clerestory::test {
namespace {

FrameRequest sized(std::uint32_t width, std::uint32_t height) {
    FrameRequest request;
    request.width = width;
    request.height = height;
    return request;
}

// A machine whose frames take a fixed time and a time per pixel.
struct Machine {
    double fixed = 0.0, full = 400.0;
    double operator()(const Level& level) const { return fixed + full * level.cost(); }
};

// Draws that many frames in motion; the levels.
std::vector<std::size_t> motion(Pace& pace, const Machine& machine, int frames) {
    std::vector<std::size_t> levels;
    for (int i = 0; i < frames; ++i) {
        const std::size_t level = pace.moving();
        levels.push_back(level);
        pace.measured(level, machine(pace.ladder().levels[level]));
    }
    return levels;
}

TEST(Ladder, EachLevelCostsLessAndTheFirstIsTheRequest) {
    const Ladder ladder = ladderOf(sized(1280, 720));
    EXPECT_EQ(ladder.levels.front(), Level{});
    EXPECT_EQ(ladder.levels.size(), 8u);
    for (std::size_t i = 1; i < ladder.levels.size(); ++i) {
        EXPECT_LT(ladder.levels[i].cost(), ladder.levels[i - 1].cost());
    }
    EXPECT_EQ(ladder.levels.back(), (Level{0.125, true}));
}

TEST(Ladder, SmallRequestsHaveFewLevels) {
    EXPECT_EQ(ladderOf(sized(64, 48)).levels.size(), 1u);
    for (const Level& level : ladderOf(sized(320, 180)).levels) EXPECT_GE(level.scale, 0.5);
}

TEST(Ladder, ARequestOfDraftHasEachSizeOnce) {
    FrameRequest request = sized(1280, 720);
    request.accuracy = accuracyOf(Preset::draft);
    const Ladder ladder = ladderOf(request);
    EXPECT_EQ(ladder.levels.size(), 7u);
    for (const Level& level : ladder.levels) EXPECT_FALSE(level.draft);
}

TEST(Ladder, ABudgetIsUsedAtFullSizeOnly) {
    FrameRequest request = sized(1280, 720);
    request.accuracy.maxMilliseconds = 50.0;
    const Ladder ladder = ladderOf(request);
    for (std::size_t i = 1; i < ladder.levels.size(); ++i) {
        EXPECT_TRUE(ladder.levels[i].draft);
        EXPECT_FALSE(atLevel(request, ladder.levels[i]).accuracy.isBudget());
    }
    EXPECT_TRUE(atLevel(request, ladder.levels[0]).accuracy.isBudget());
}

TEST(Ladder, ALevelShowsTheSamePicture) {
    FrameRequest request = sized(1281, 720);
    request.camera.intrinsics = Intrinsics{1000, 900, 640, 360, PixelCenter::integer};
    request.filters = {TwirlFilter{.amount = 2.0, .radius = 100.0}, TwirlFilter{.amount = 1.0},
                       GlowFilter{.radius = 32.0}};
    const FrameRequest half = atLevel(request, {0.5, true});
    EXPECT_EQ(half.width, 641u);
    EXPECT_EQ(half.height, 360u);
    const double x = 641.0 / 1281.0;
    EXPECT_DOUBLE_EQ(half.camera.intrinsics->fx, 1000 * x);
    EXPECT_DOUBLE_EQ(half.camera.intrinsics->fy, 450);
    // The corner of the picture keeps its direction.
    EXPECT_DOUBLE_EQ((half.camera.intrinsics->cx + 0.5) / half.camera.intrinsics->fx, 640.5 / 1000);
    EXPECT_DOUBLE_EQ(half.camera.intrinsics->cy, 179.75);
    EXPECT_EQ(std::get<TwirlFilter>(half.filters[0]).radius, 50.0);
    EXPECT_EQ(std::get<TwirlFilter>(half.filters[0]).amount, 2.0);
    EXPECT_EQ(std::get<TwirlFilter>(half.filters[1]).radius, std::nullopt);
    EXPECT_EQ(std::get<GlowFilter>(half.filters[2]).radius, 16.0);
    EXPECT_EQ(half.accuracy, accuracyOf(Preset::draft));
}

TEST(Pace, TheFirstFrameIsTheSmallestAndTheSecondMeetsTheTarget) {
    for (const double full : {50.0, 400.0, 3000.0}) {
        const Machine machine{.full = full};
        Pace pace(ladderOf(sized(1280, 720)), 100.0);
        EXPECT_EQ(pace.moving(), pace.ladder().levels.size() - 1);
        motion(pace, machine, 1);
        const std::size_t level = pace.moving();
        EXPECT_LE(machine(pace.ladder().levels[level]), 100.0) << full;
        if (level == 0) continue;
        EXPECT_GT(machine(pace.ladder().levels[level - 1]), 80.0) << full;
    }
}

TEST(Pace, AFixedPartOfTheTimeIsDiscovered) {
    const Machine machine{.fixed = 40.0, .full = 200.0};
    Pace pace(ladderOf(sized(1280, 720)), 100.0);
    const std::size_t last = motion(pace, machine, 60).back();
    EXPECT_LE(machine(pace.ladder().levels[last]), 120.0);
    EXPECT_LE(last, 3u);
}

TEST(Pace, SteadyTimesKeepTheLevel) {
    const Machine machine{.full = 400.0};
    Pace pace(ladderOf(sized(1280, 720)), 100.0);
    const auto levels = motion(pace, machine, 200);
    for (std::size_t i = 20; i < levels.size(); ++i) EXPECT_EQ(levels[i], levels[20]) << i;
}

TEST(Pace, OneSlowFrameIsNoReason) {
    Pace pace(ladderOf(sized(1280, 720)), 100.0);
    motion(pace, {}, 10);
    const std::size_t level = pace.moving();
    pace.measured(level, 150.0);
    EXPECT_EQ(pace.moving(), level);
    pace.measured(level, 90.0);
    pace.measured(level, 150.0);
    EXPECT_EQ(pace.moving(), level);
    pace.measured(level, 150.0);
    EXPECT_GT(pace.moving(), level);
}

TEST(Pace, AHeavierViewLeadsToSmallerFramesAndALighterOneBack) {
    Pace pace(ladderOf(sized(1280, 720)), 100.0);
    const std::size_t light = motion(pace, {}, 20).back();
    const auto heavy = motion(pace, {.full = 1600.0}, 6);
    EXPECT_GT(heavy.back(), light);
    EXPECT_LE(1600.0 * pace.ladder().levels[pace.moving()].cost(), 120.0);
    motion(pace, {}, 300);
    EXPECT_EQ(pace.moving(), light);
}

TEST(Pace, ALevelThatProvedTooSlowIsRarelyTriedAgain) {
    // The next finer level looks fast by its pixels and is not.
    Pace pace(ladderOf(sized(1280, 720)), 100.0);
    const auto time = [](std::size_t level) { return level >= 4 ? 50.0 : 130.0; };
    int slow = 0;
    for (int i = 0; i < 400; ++i) {
        const std::size_t level = pace.moving();
        slow += level < 4 ? 1 : 0;
        pace.measured(level, time(level));
    }
    EXPECT_LE(slow, 20);
    EXPECT_GE(slow, 2);
}

TEST(Pace, NoFrameIsSmallerThanTheSmallestOrLargerThanTheRequest) {
    Pace slow(ladderOf(sized(640, 360)), 100.0);
    motion(slow, {.full = 1e6}, 20);
    EXPECT_EQ(slow.moving(), slow.ladder().levels.size() - 1);
    Pace fast(ladderOf(sized(640, 360)), 100.0);
    motion(fast, {.full = 1.0}, 20);
    EXPECT_EQ(fast.moving(), 0u);
    Pace only(ladderOf(sized(64, 48)), 100.0);
    motion(only, {.full = 1e6}, 20);
    EXPECT_EQ(only.moving(), 0u);
}

// The levels from a frame in motion to the request itself.
std::vector<std::size_t> refinement(Pace& pace, const Machine& machine) {
    std::vector<std::size_t> levels;
    for (std::size_t level = pace.moving(); level > 0;) {
        level = pace.refined(level);
        levels.push_back(level);
        pace.measured(level, machine(pace.ladder().levels[level]));
    }
    return levels;
}

TEST(Pace, ACheapRequestIsRefinedInOneStepAndAnExpensiveOneInTwo) {
    for (const auto& [full, steps] : {std::pair(150.0, 1u), {500.0, 2u}, {3000.0, 2u}}) {
        Pace pace(ladderOf(sized(1280, 720)), 100.0);
        const Machine machine{.full = full};
        motion(pace, machine, 10);
        const std::size_t before = pace.moving();
        const auto levels = refinement(pace, machine);
        ASSERT_EQ(levels.size(), steps) << full;
        EXPECT_EQ(levels.back(), 0u);
        EXPECT_LT(levels.front(), before);
        if (steps == 2) {
            EXPECT_LE(machine(pace.ladder().levels[levels.front()]), std::max(200.0, full / 4));
        }
        EXPECT_EQ(pace.moving(), before) << "motion goes on at its own level";
    }
}

}  // namespace
}  // namespace clerestory::test
