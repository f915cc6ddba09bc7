// Hulls, records and diagrams of curves with known results.
#include "accuracy_record.h"
#include "accuracy_report.h"
#include "accuracy_rows.h"
#include "accuracy_text.h"

#include <gmock/gmock.h>

namespace clerestory::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Point point(const std::string& setting, double ms, double error) {
    return {.scene = "room", .setting = setting, .medianMs = ms, .relMse = error};
}

TEST(AccuracyHull, IsTheLowerLeftHull) {
    // Corners 0, 3, 4; 1 is slower and worse, 2 is above the line from 0 to 3, 5 is worse than 4.
    const std::vector<CostAndError> points = {{1, 1},     {2, 2},      {3, 0.9},
                                              {10, 0.01}, {100, .005}, {200, 0.006}};
    EXPECT_THAT(lowerHull(points), ElementsAre(0u, 3u, 4u));
}

TEST(AccuracyHull, IsConvexInLogarithms) {
    // (10, 0.1) lies on the straight line of the logarithms, 10 % below it is a corner.
    EXPECT_THAT(lowerHull({{1, 1}, {10, 0.09}, {100, 0.01}}), ElementsAre(0u, 1u, 2u));
    EXPECT_THAT(lowerHull({{1, 1}, {10, 0.11}, {100, 0.01}}), ElementsAre(0u, 2u));
}

TEST(AccuracyHull, KeepsTheFirstOfEqualPoints) {
    EXPECT_THAT(lowerHull({{2, 1}, {1, 1}, {1, 1}}), ElementsAre(1u));
    EXPECT_TRUE(lowerHull({}).empty());
}

TEST(AccuracyHull, ToleratesSmallDifferences) {
    const std::vector<CostAndError> points = {{10, 1.0}, {10.6, 1.06}, {10.6, 1.04}, {10.4, 2.0}};
    EXPECT_EQ(betterInBoth(points, 1, 0.05), 0u);
    EXPECT_FALSE(betterInBoth(points, 2, 0.05)) << "4 % more error";
    EXPECT_FALSE(betterInBoth(points, 3, 0.05)) << "4 % more time";
    EXPECT_FALSE(betterInBoth(points, 0, 0.05));
}

TEST(AccuracyRecord, RoundTrips) {
    const Points points = {point("draft", 1, 0.1), point("fine", 2, 0.0)};
    const std::string record = recordOf(points, "some driver");
    const Held same = heldAgainst(record, points);
    EXPECT_EQ(same.held, 2);
    EXPECT_EQ(same.missing, 0);
    EXPECT_TRUE(same.exceeded.empty());

    Points worse = points;
    worse[0].relMse = 0.1049;
    EXPECT_TRUE(heldAgainst(record, worse).exceeded.empty());
    worse[0].relMse = 0.1051;
    EXPECT_THAT(heldAgainst(record, worse).exceeded, ElementsAre(HasSubstr("room,frame,draft")));
    worse[0].setting = "unheard of";
    EXPECT_EQ(heldAgainst(record, worse).missing, 1);
    EXPECT_ANY_THROW(heldAgainst("room,frame,draft,much", points));
}

TEST(AccuracyReport, NamesPresetsOffTheHull) {
    Points points = {point("standard", 10, 0.1), point("standard, probeSize 64", 8, 0.05)};
    points[0].preset = Preset::standard;
    EXPECT_THAT(markdownOf(points), HasSubstr("`standard` (0.1, 10 ms) against `standard, "
                                              "probeSize 64` (0.05, 8 ms)"));
    EXPECT_THAT(hullCsvOf(points),
                HasSubstr("room,frame,standard,0.1,10.0,0,\"standard, probeSize 64\"\n"));
    EXPECT_THAT(settingsCsvOf(points), HasSubstr("\"standard, probeSize 64\",frame,0.50,0.80,1\n"));
    points[1].medianMs = 12;
    EXPECT_THAT(markdownOf(points), HasSubstr("None."));
}

TEST(AccuracyReport, QuotesCommas) {
    EXPECT_THAT(csvOf({point("standard, probeSize 64", 8, 0.05)}),
                HasSubstr("room,frame,\"standard, probeSize 64\",8.00"));
}

TEST(AccuracyReport, CanBeReadBack) {
    Points points = {point("fine", 10, 0.1), point("standard, probeSize 64", 8, 0.05)};
    points[0].preset = Preset::fine;
    points[0].processorMs = 15.5;
    points[1].effect = Effect::refraction;
    points[1].totals.draws = 12;
    points.push_back(point("draft", 6, 0.2));
    points[2].effect = Effect::materialLayers;
    EXPECT_EQ(csvOf(pointsFrom(csvOf(points))), csvOf(points));
    EXPECT_EQ(pointsFrom(csvOf(points))[0].preset, Preset::fine);
    EXPECT_ANY_THROW(pointsFrom("room,frame,fine,1,2"));
    EXPECT_THAT(markdownOf(points, Clock::processor), HasSubstr("0.1, 16 ms"));
}

TEST(AccuracyPicture, ShowsExistingEffects) {
    Points points = {point("standard", 10, 0.1), point("a <b>", 8, 0.0)};
    points[0].preset = Preset::standard;
    const std::string svg = svgOf(points, Effect::base);
    EXPECT_THAT(svg, HasSubstr("a &lt;b>"));
    EXPECT_THAT(svg, testing::Not(HasSubstr("nan")));
    EXPECT_TRUE(svgOf(points, Effect::refraction).empty());
}

}  // namespace
}  // namespace clerestory::bench
