// R3: the samples that a frame shades, counted by hand, and the rejection of frames above the
// limit.
#include "plan/graph/work.h"
#include "view_planner_support.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

constexpr std::uint64_t kPixels = 160 * 90;  // of lookingFrom()

std::uint64_t samplesOf(const FramePlan& plan, std::string_view kind) {
    std::uint64_t sum = 0;
    for (const Pass& pass : passesOf(plan, kind)) sum += shadedSamples(plan, pass);
    return sum;
}

FrameRequest plainRequest() {
    FrameRequest request = lookingFrom({0, 1, 6});
    request.accuracy.environmentSize = 16;
    request.accuracy.environmentSamples = 8;
    return request;
}

std::set<std::string> refusedKnobs(const FramePlan& plan, std::uint64_t most) {
    std::set<std::string> pointers;
    try {
        requireAffordable(plan, most);
    } catch (const InvalidRequest& refusal) {
        for (const FieldError& e : refusal.errors()) {
            EXPECT_NE(e.allowed.find(std::to_string(most)), std::string::npos) << e.allowed;
            EXPECT_NE(e.detail.find(std::to_string(shadedSamples(plan))), std::string::npos);
            pointers.insert(e.pointer);
        }
    }
    return pointers;
}

TEST(Work, IsPixelsTimesSamplesOverAllPasses) {
    FrameRequest request = plainRequest();
    const FramePlan plan = planOf(boxScene(), request);
    EXPECT_EQ(samplesOf(plan, "surface"), kPixels);
    EXPECT_EQ(samplesOf(plan, "toneMap"), kPixels);
    EXPECT_EQ(samplesOf(plan, "edgeFilter"), kPixels);
    // Six faces of every level, eight directions for each texel.
    const TargetSpec& map = plan.targets[passesOf(plan, "environment").at(0).target];
    std::uint64_t texels = 0;
    for (std::uint32_t level = 0; level < map.levels; ++level) {
        texels += 6 * (16ull >> level) * (16ull >> level);
    }
    EXPECT_EQ(samplesOf(plan, "environment"), 8 * texels);
    EXPECT_EQ(shadedSamples(plan), 3 * kPixels + 8 * texels);

    request.accuracy.samples = 4;
    request.accuracy.sampleShare = 0.5;
    EXPECT_EQ(samplesOf(planOf(boxScene(), request), "surface"), kPixels);
    EXPECT_EQ(samplesOf(planOf(boxScene(), request), "supersampling"), 3 * kPixels / 2)
        << "of half of the pixels, at most";
    EXPECT_EQ(shadedSamples(planOf(boxScene(), request, allOf(plan))),
              (1 + 1 + 1) * kPixels + 3 * kPixels / 2)
        << "resident maps cost nothing";
}

TEST(Work, MapWorkGrowsWithItsKnobs) {
    FrameRequest request = forced(plainRequest());
    const auto prefiltered = [&] { return samplesOf(planOf(ballScene(), request), "prefilter"); };
    const std::uint64_t once = prefiltered();
    EXPECT_GT(once, 0u);
    request.accuracy.probeSamples *= 2;
    EXPECT_EQ(prefiltered(), 2 * once);
    request.accuracy.generations = 1;
    EXPECT_EQ(prefiltered(), once);
    request.accuracy.probeSize *= 2;
    EXPECT_GT(prefiltered(), 3 * once);
}

TEST(Work, RaysCountForEveryBounceOfEveryPixel) {
    FrameRequest request = plainRequest();
    request.accuracy.curved = CurvedMethod::traced;
    request.accuracy.bounces = 5;
    const FramePlan plan = planOf(ballScene(), request);
    ASSERT_TRUE(followsRays(passesOf(plan, "surface").at(0))) << toText(plan);
    EXPECT_EQ(samplesOf(plan, "surface"), (1 + 5) * kPixels);
}

TEST(Work, BudgetsAreExactToTheSample) {
    const FramePlan plan = planOf(ballScene(), forced(plainRequest()));
    const std::uint64_t all = shadedSamples(plan);
    EXPECT_NO_THROW(requireAffordable(plan, all));
    EXPECT_THROW(requireAffordable(plan, all - 1), InvalidRequest);
    EXPECT_NO_THROW(requireAffordable(plan, 0)) << "any";
    FrameRequest request = plainRequest();
    EXPECT_NO_THROW(requireAffordable(request, kPixels));
    EXPECT_THROW(requireAffordable(request, kPixels - 1), InvalidRequest);
    EXPECT_LE(minShadedSamples(request), all);
}

TEST(Work, RejectionsNameTheResponsibleKnobs) {
    FrameRequest request = plainRequest();
    EXPECT_EQ(refusedKnobs(planOf(boxScene(), request), 100),
              (std::set<std::string>{"/width", "/height", "/accuracy/environmentSize",
                                     "/accuracy/environmentSamples"}));
    request.accuracy.samples = 4;
    const auto ofSamples = refusedKnobs(planOf(boxScene(), request), 100);
    for (const char* pointer : {"/accuracy/samples", "/accuracy/sampleShare"}) {
        EXPECT_TRUE(ofSamples.contains(pointer)) << pointer;
    }
    request = forced(request);
    request.filters = {GlowFilter{}};
    const auto knobs = refusedKnobs(planOf(ballScene(), request), 100);
    for (const char* pointer : {"/accuracy/probeSize", "/accuracy/probeSamples",
                                "/accuracy/generations", "/filters", "/width"}) {
        EXPECT_TRUE(knobs.contains(pointer)) << pointer;
    }
}

}  // namespace
}  // namespace clerestory::test
