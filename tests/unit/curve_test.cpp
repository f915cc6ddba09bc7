// Budgets: the choice from a curve, its description, and how a curve is measured and refined.
#include "comparison/curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// Each point is slower and more exact than the previous one, except that the fourth is worse than
// the third in both.
Curve curveOf() {
    const double milliseconds[] = {10, 20, 40, 50, 100};
    const double errors[] = {0.8, 0.4, 0.2, 0.3, 0.1};
    Curve curve;
    for (int i = 0; i < 5; ++i) {
        curve.points.push_back({curveSettings()[static_cast<std::size_t>(i)], milliseconds[i], errors[i]});
    }
    return curve;
}

Accuracy within(std::optional<double> milliseconds, std::optional<double> error) {
    Accuracy budget;
    budget.maxMilliseconds = milliseconds;
    budget.maxError = error;
    return budget;
}

TEST(Budget, TimeLimitsMinimiseErrorAndErrorLimitsTime) {
    const Curve curve = curveOf();
    EXPECT_EQ(choose(curve, within(45, {})).point, 2u);
    EXPECT_EQ(choose(curve, within(60, {})).point, 2u)
        << "a slower and worse point is never chosen";
    EXPECT_EQ(choose(curve, within(1000, {})).point, 4u);
    EXPECT_EQ(choose(curve, within({}, 0.35)).point, 2u);
    EXPECT_EQ(choose(curve, within({}, 0.9)).point, 0u);
    EXPECT_EQ(choose(curve, within(60, 0.5)).point, 1u) << "the cheapest within both";
    for (const Accuracy& met : {within(45, {}), within({}, 0.35), within(60, 0.5)}) {
        EXPECT_TRUE(choose(curve, met).met);
        EXPECT_THAT(choose(curve, met).words, Not(HasSubstr("no setting meets")));
    }
}

TEST(Budget, UnattainableBudgetsTakeTheNearestPoint) {
    const Curve curve = curveOf();
    EXPECT_EQ(choose(curve, within(5, {})).point, 0u) << "the cheapest";
    EXPECT_EQ(choose(curve, within({}, 0.01)).point, 4u) << "the truest";
    EXPECT_EQ(choose(curve, within(45, 0.01)).point, 2u) << "time takes precedence";
    EXPECT_EQ(choose(curve, within(5, 0.01)).point, 0u);
    for (const Accuracy& missed :
         {within(5, {}), within({}, 0.01), within(45, 0.01), within(5, 0.01)}) {
        EXPECT_FALSE(choose(curve, missed).met);
        EXPECT_THAT(choose(curve, missed).words, HasSubstr("no setting meets the budget"));
    }
    EXPECT_THAT(choose(curve, within(45, {})).words, HasSubstr("not chosen"));
    EXPECT_THAT(choose(curve, within(1000, {})).words, Not(HasSubstr("not chosen")));
}

TEST(Budget, MeasuredFramesRefineAPoint) {
    CurvePoint point{.milliseconds = 100.0};
    refine(point, 200.0);
    EXPECT_DOUBLE_EQ(point.milliseconds, 120.0);
    for (int i = 0; i < 100; ++i) refine(point, 200.0);
    EXPECT_NEAR(point.milliseconds, 200.0, 1e-6);
    refine(point, 0.0);
    refine(point, std::numeric_limits<double>::quiet_NaN());
    EXPECT_NEAR(point.milliseconds, 200.0, 1e-6);
}

// A truth of 1 everywhere; each setting is off by its place in the ladder, and costs as much.
TEST(Curve, EachSettingIsComparedAtTheReducedSize) {
    FrameRequest frame;
    frame.width = 1280;
    frame.height = 640;
    frame.camera.intrinsics = Intrinsics{.fx = 1280, .fy = 1280, .cx = 640, .cy = 320};
    std::vector<FrameRequest> drawn;
    const auto trace = [](const FrameRequest& small, std::uint32_t) {
        ReferenceImage truth;
        EXPECT_EQ(small.width, 320u);
        EXPECT_EQ(small.height, 160u);
        EXPECT_DOUBLE_EQ(small.camera.intrinsics->fx, 320.0);
        EXPECT_DOUBLE_EQ(small.camera.intrinsics->cy, 80.0);
        truth.color = makeImage(small.width, small.height, 3, PixelType::float32);
        truth.noise = truth.color;
        std::fill_n(truth.color.floats(), 320 * 160 * 3, 1.0f);
        std::fill_n(truth.noise.floats(), 320 * 160 * 3, 0.01f);
        return std::optional(truth);
    };
    const std::vector<Accuracy> steps = curveSettings();
    const auto place = [&](const Accuracy& accuracy) {
        return std::find(steps.begin(), steps.end(), accuracy) - steps.begin();
    };
    const auto draw = [&](const FrameRequest& request) {
        drawn.push_back(request);
        DrawnFrame result{.milliseconds = 1.0 + static_cast<double>(place(request.accuracy))};
        const bool linear = request.output.format == OutputFormat::npy;
        EXPECT_EQ(request.width, linear ? 320u : 1280u);
        result.image = makeImage(request.width, request.height, 3,
                                 linear ? PixelType::float32 : PixelType::srgb8);
        if (linear) {
            const float off = 0.1f * static_cast<float>(place(request.accuracy));
            std::fill_n(result.image.floats(), 320 * 160 * 3, 1.0f + off);
        }
        return result;
    };
    double reported = 0.0;
    const auto curve = measureCurve(frame, trace, draw, [&](double share) {
        EXPECT_GE(share, reported);
        reported = share;
        return true;
    });
    ASSERT_TRUE(curve);
    ASSERT_EQ(curve->points.size(), steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        EXPECT_EQ(curve->points[i].accuracy, steps[i]);
        EXPECT_DOUBLE_EQ(curve->points[i].milliseconds, 1.0 + static_cast<double>(i));
        EXPECT_NEAR(curve->points[i].relMse, std::pow(0.1 * static_cast<double>(i), 2), 1e-3);
    }
    EXPECT_NEAR(curve->relMseNoise, 1e-4, 1e-6);
    EXPECT_FALSE(measureCurve(frame, trace, draw, [](double) { return false; }));
}

TEST(Settings, NamesListDifferencesFromThePreset) {
    EXPECT_EQ(nameOf(accuracyOf(Preset::fine)), "fine");
    Accuracy a = accuracyOf(Preset::standard);
    a.probeSize = 512;
    a.glass = GlassMethod::traced;
    EXPECT_EQ(nameOf(a), "standard, glass traced, probeSize 512");
}

TEST(Settings, AreUniqueAndStartWithTheFrames) {
    ComparisonRequest request;
    EXPECT_EQ(settingsOf(request).size(), 3u);
    EXPECT_EQ(settingsOf(request).front(), accuracyOf(Preset::standard));
    request.settings = {accuracyOf(Preset::fine), accuracyOf(Preset::fine)};
    EXPECT_EQ(settingsOf(request).size(), 1u);
}

}  // namespace
}  // namespace clerestory::test
