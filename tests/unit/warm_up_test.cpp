// Warm-up plans contain every program of their source plan and little else.
#include "plan/warm_up.h"
#include "plan/graph/features.h"
#include "view_planner_support.h"

#include <algorithm>
#include <bit>

namespace clerestory::test {
namespace {

// Shaded draws, then blended ones.
std::vector<std::span<const Draw>> shadedLists(const Pass& pass) {
    auto lists = pass.drawLists();
    if (std::holds_alternative<DrawScene>(pass.work)) lists.erase(lists.begin());
    return lists;
}

using Program = std::tuple<std::string_view, bool, Features>;  // bool: blended

std::set<Program> programsOf(const FramePlan& plan) {
    std::set<Program> programs;
    for (const Pass& pass : plan.passes) {
        const auto lists = shadedLists(pass);
        for (std::size_t i = 0; i < lists.size(); ++i) {
            for (const Draw& draw : lists[i]) programs.emplace(pass.kind(), i > 0, draw.features);
        }
        if (!pass.view()) programs.emplace(pass.kind(), false, 0);
    }
    return programs;
}

FramePlan planOfBalls() {
    FrameRequest request = lookingFrom({0, 0.5, 6});
    request.accuracy.generations = 2;
    return planOf(ballScene(), request);
}

TEST(WarmUpPlan, DrawsEveryProgramOfThePlan) {
    for (const FramePlan& plan :
         {planOfBalls(), planOf(mirrorScene(), lookingFrom({0.3, 0.2, 5}))}) {
        EXPECT_EQ(programsOf(WarmUpPlanner().plan(plan)), programsOf(plan)) << toText(plan);
    }
}

TEST(WarmUpPlan, HasOnePassPerProgram) {
    const FramePlan warm = WarmUpPlanner().plan(planOfBalls());
    for (const Pass& pass : warm.passes) {
        std::set<Features> features;
        for (const std::span<const Draw> draws : shadedLists(pass)) {
            for (const Draw& draw : draws) features.insert(draw.features);
        }
        EXPECT_LE(features.size(), 1u) << pass.name;
    }
    // Twelve face views for each generation draw the same programs.
    EXPECT_LT(warm.passes.size(), 24u) << toText(warm);
}

TEST(WarmUpPlan, LeavesOutWhatEarlierPlansDraw) {
    WarmUpPlanner planner;
    const FramePlan plan = planOfBalls();
    planner.plan(plan);
    EXPECT_TRUE(planner.plan(plan).passes.empty());
    const FramePlan other = planOf(mirrorScene(), lookingFrom({0.3, 0.2, 5}));
    std::set<Program> left = programsOf(other);
    for (const Program& known : programsOf(plan)) left.erase(known);
    ASSERT_FALSE(left.empty());
    const std::set<Program> further = programsOf(planner.plan(other));
    EXPECT_TRUE(std::includes(further.begin(), further.end(), left.begin(), left.end()));
}

// Another thread builds the hierarchy of the scene meanwhile.
TEST(WarmUpPlan, FollowsRaysAfterEverythingElse) {
    FrameRequest request = lookingFrom({0, 0.5, 6});
    request.accuracy.curved = CurvedMethod::traced;
    const FramePlan plan = planOnProcessor(ballScene(), request);
    const FramePlan warm = WarmUpPlanner().plan(plan);
    const auto follows = [](const Pass& pass) {
        return std::holds_alternative<FollowRays>(pass.work);
    };
    EXPECT_FALSE(follows(plan.passes.back()));
    const auto first = std::find_if(warm.passes.begin(), warm.passes.end(), follows);
    EXPECT_NE(first, warm.passes.end()) << toText(warm);
    EXPECT_TRUE(std::all_of(first, warm.passes.end(), follows)) << toText(warm);
}

TEST(WarmUpPlan, KeepsEnvironmentMapsAndShrinksOtherTargets) {
    const FramePlan plan = planOfBalls();
    const FramePlan warm = WarmUpPlanner().plan(plan);
    ASSERT_EQ(warm.targets.size(), plan.targets.size());
    for (std::size_t i = 0; i < plan.targets.size(); ++i) {
        const TargetSpec &was = plan.targets[i], &is = warm.targets[i];
        if (is.name.starts_with("environment:")) {
            EXPECT_EQ(is, was);
            continue;
        }
        EXPECT_EQ(is.residentKey, 0u) << is.name;
        EXPECT_LE(std::max(is.width, is.height), 12u) << is.name;
        EXPECT_EQ(std::has_single_bit(is.width), std::has_single_bit(was.width)) << is.name;
        EXPECT_EQ(std::has_single_bit(is.height), std::has_single_bit(was.height)) << is.name;
        EXPECT_EQ(is.levels > 1, was.levels > 1) << is.name;
        EXPECT_EQ(is.format, was.format) << is.name;
    }
}

}  // namespace
}  // namespace clerestory::test
