// The passes of a request's filters.
#include "plan_scenes.h"

#include <gmock/gmock.h>

namespace clerestory::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

FilterRequest twirl(double amount) {
    return TwirlFilter{.amount = amount};
}
FilterRequest glow(double radius) {
    return GlowFilter{.radius = radius};
}

FramePlan planWith(std::vector<FilterRequest> filters, OutputFormat format = OutputFormat::jpeg) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.filters = std::move(filters);
    request.output.format = format;
    return planOf(boxScene(), request);
}

// The passes of the filters; other passes between them are one entry.
std::vector<std::string_view> filterKinds(const FramePlan& plan) {
    std::vector<std::string_view> kinds;
    for (const Pass& pass : plan.passes) {
        if (pass.effect == Effect::filters) kinds.push_back(pass.kind());
    }
    return kinds;
}

TEST(FilterPlan, FiltersRunBetweenSceneAndToneMapping) {
    const FramePlan plan = planWith({twirl(1), glow(4)});
    std::vector<std::string_view> kinds;
    for (const Pass& pass : plan.passes) kinds.push_back(pass.kind());
    EXPECT_THAT(kinds, ElementsAre("environment", "surface", "twirl", "glowBright", "glowDown",
                                   "glowUp", "glow", "toneMap", "edgeFilter"));
    for (std::size_t i = 2; i + 2 < plan.passes.size(); ++i) {
        EXPECT_EQ(plan.passes[i].effect, Effect::filters);
    }
}

TEST(FilterPlan, EachFilterReadsThePreviousResult) {
    const std::vector<FilterRequest> eight(kMaxFilters, twirl(1));
    const FramePlan plan = planWith(eight, OutputFormat::npy);
    TargetId picture = 0;
    std::set<TargetId> written;
    for (const Pass& pass : plan.passes) {
        if (pass.kind() == "surface") picture = pass.target;
        if (pass.kind() != "twirl") continue;
        EXPECT_THAT(pass.reads(), ElementsAre(picture));
        EXPECT_NE(pass.target, picture);
        EXPECT_EQ(plan.targets[pass.target].format, Format::rgba32f);
        picture = pass.target;
        written.insert(picture);
    }
    EXPECT_EQ(plan.output, picture);
    EXPECT_EQ(written.size(), 2u) << "two targets alternate";
}

TEST(FilterPlan, TheGlowPyramidReachesItsRadius) {
    EXPECT_EQ(filterKinds(planWith({glow(2)})).size(), 2u);
    EXPECT_EQ(filterKinds(planWith({glow(2.1)})).size(), 4u);
    EXPECT_EQ(filterKinds(planWith({glow(32)})).size(), 10u);
    const FramePlan plan = planWith({glow(8192)});
    for (const TargetSpec& target : plan.targets) {
        EXPECT_GT(target.width, 0u);
        EXPECT_GT(target.height, 0u);
    }
}

TEST(FilterPlan, IneffectiveFiltersAreOmittedWithAReason) {
    const FramePlan plain = planWith({});
    const FramePlan plan =
        planWith({twirl(0), TwirlFilter{.amount = 1.0, .radius = 0.0},
                  ConvolveFilter{.kernel = KernelNumbers{0, 0, 0, 0, 1, 0, 0, 0, 0}},
                  GlowFilter{.strength = 0.0}, glow(1)});
    EXPECT_EQ(plan.passes, plain.passes);
    EXPECT_EQ(plan.targets, plain.targets);
    const auto skipped = [](const char* name, const char* reason) {
        return Contains(AllOf(Field(&Skipped::name, name), Field(&Skipped::effect, Effect::filters),
                              Field(&Skipped::reason, HasSubstr(reason))));
    };
    EXPECT_THAT(plan.skipped, skipped("filter0:twirl", "amount of 0"));
    EXPECT_THAT(plan.skipped, skipped("filter1:twirl", "radius of 0"));
    EXPECT_THAT(plan.skipped, skipped("filter2:convolve", "identity"));
    EXPECT_THAT(plan.skipped, skipped("filter3:glow", "strength of 0"));
    EXPECT_THAT(plan.skipped, skipped("filter4:glow", "at most one pixel"));
    const Subject last{Subject::Kind::filter, "glow", 4};
    EXPECT_THAT(plan.skipped, Contains(Field(&Skipped::subject, last)));
}

TEST(FilterPlan, DataChannelsAreNotFiltered) {
    FrameRequest request = lookingFrom({0, 0, 5});
    request.filters = {twirl(1)};
    request.output = {.format = OutputFormat::npy, .channel = Channel::depth};
    const FramePlan plan = planOf(boxScene(), request);
    EXPECT_TRUE(filterKinds(plan).empty());
    EXPECT_THAT(plan.skipped,
                Contains(Field(&Skipped::reason, HasSubstr("data channel instead of colour"))));
}

}  // namespace
}  // namespace clerestory::test
