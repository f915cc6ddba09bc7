// Which passes give further samples, and where they are.
#include "plan/graph/supersampling.h"

#include "view_planner_support.h"

#include <gmock/gmock.h>
#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory::test {
namespace {

using testing::Contains;
using testing::Not;

const Pass* supersamplingOf(const FramePlan& plan) {
    const auto found = std::find_if(plan.passes.begin(), plan.passes.end(), [](const Pass& pass) {
        return std::holds_alternative<Supersampling>(pass.work);
    });
    return found == plan.passes.end() ? nullptr : &*found;
}

std::vector<std::string_view> repeatedKinds(const FramePlan& plan) {
    std::vector<std::string_view> kinds;
    for (const auto& [pass, part] : std::get<Supersampling>(supersamplingOf(plan)->work).passes) {
        kinds.push_back(plan.passes[pass].kind());
    }
    return kinds;
}

FrameRequest withSamples(FrameRequest request, std::uint32_t samples) {
    request.accuracy.samples = samples;
    return request;
}

TEST(SupersamplingPlan, OneSampleNeedsNoPass) {
    const FrameRequest request = lookingFrom({0, 0, 5});
    EXPECT_EQ(supersamplingOf(planOf(boxScene(), request)), nullptr);
    const FramePlan plan = planOf(boxScene(), withSamples(request, 2));
    ASSERT_NE(supersamplingOf(plan), nullptr);
    EXPECT_THAT(repeatedKinds(plan), testing::ElementsAre("surface"));
}

// The maps of a frame do not depend on where a view has its samples.
TEST(SupersamplingPlan, MapsAreNotDrawnAgain) {
    FrameRequest request = withSamples(forced(lookingFrom({0, 0, 4})), 4);
    request.effects.shadows = true;
    const FramePlan plan = planOf(mirrorScene(), request);
    for (const char* map : {"environment", "capture", "prefilter", "shadow"}) {
        EXPECT_THAT(repeatedKinds(plan), Not(Contains(map)));
    }
}

TEST(SupersamplingPlan, ChannelsHaveOneSample) {
    FrameRequest request = withSamples(lookingFrom({0, 0, 5}), 4);
    request.output = {.format = OutputFormat::npy, .channel = Channel::depth};
    EXPECT_EQ(supersamplingOf(planOf(boxScene(), request)), nullptr);
}

// A mirrored view is a part of the picture: its pixels are at those that show it.
TEST(SupersamplingPlan, MirroredViewsAreDrawnAgainInTheirPlace) {
    for (const double scale : {1.0, 0.5}) {
        FrameRequest request = withSamples(forced(lookingFrom({0.3, 0.2, 5})), 4);
        request.accuracy.planarScale = scale;
        const FramePlan plan = planOf(mirrorScene(), request);
        EXPECT_THAT(repeatedKinds(plan), Contains("mirror"));
        const auto& work = std::get<Supersampling>(supersamplingOf(plan)->work);
        ASSERT_EQ(work.parts.size(), 2u);
        const auto surface =
            std::find_if(plan.passes.begin(), plan.passes.end(),
                         [](const Pass& pass) { return pass.kind() == "surface"; });
        const auto& reflections = std::get<DrawScene>(surface->work).reflections;
        ASSERT_FALSE(reflections.empty());
        const auto& [origin, partScale, chosen] = work.parts[1];
        EXPECT_EQ(partScale, reflections.front().scale);
        EXPECT_EQ(origin, reflections.front().origin);
        EXPECT_EQ(plan.targets[chosen].width, plan.targets[reflections.front().target].width);
        // A pass that reads a picture follows those that draw it.
        for (std::size_t i = 1; i < work.passes.size(); ++i) {
            EXPECT_LT(work.passes[i - 1].pass, work.passes[i].pass);
        }
    }
}

// The share of a pixel that an edge covers, of all edges that meet it, by the number of samples on
// one side and by arithmetic: root of the mean square. A rotated grid of four has 0.092.
TEST(SupersamplingPlan, PlacesShowTheCoveredArea) {
    for (const auto& [samples, bound] : {std::pair(4u, 0.099), std::pair(6u, 0.087),
                                         std::pair(8u, 0.069), std::pair(16u, 0.039)}) {
        glm::dvec2 sum(0.0);
        for (std::uint32_t i = 0; i < samples; ++i) {
            EXPECT_LE(std::max(std::abs(samplePlace(i).x), std::abs(samplePlace(i).y)), 0.5);
            sum += samplePlace(i);
        }
        EXPECT_LT(glm::length(sum), 1e-12) << samples;
        double squares = 0.0;
        int edges = 0;
        for (int turn = 0; turn < 90; ++turn) {
            const double angle = 0.003 + turn * glm::two_pi<double>() / 90.0;
            const glm::dvec2 normal(std::cos(angle), std::sin(angle));
            for (double offset = -0.7; offset < 0.7; offset += 0.02) {
                const auto covers = [&](const glm::dvec2& p) {
                    return glm::dot(p, normal) < offset;
                };
                int few = 0, many = 0;
                for (std::uint32_t i = 0; i < samples; ++i) few += covers(samplePlace(i));
                for (int i = 0; i < 32 * 32; ++i) {
                    many += covers({(i % 32 + 0.5) / 32.0 - 0.5, (i / 32 + 0.5) / 32.0 - 0.5});
                }
                if (many == 0 || many == 32 * 32) continue;
                squares += std::pow(few / double(samples) - many / 1024.0, 2.0);
                ++edges;
            }
        }
        EXPECT_LT(std::sqrt(squares / edges), bound) << samples;
    }
}

}  // namespace
}  // namespace clerestory::test
