// The part of an image that a surface covers: overlapping rectangles, areas compared with solid
// geometry.
#include "view_planner_support.h"

#include "plan/visibility/coverage.h"
#include "plan/visibility/draws.h"

#include <gtest/gtest.h>

#include <array>

namespace clerestory::test {
namespace {

ScreenBox rectangle(double left, double bottom, double right, double top) {
    return {{left, bottom}, {right, top}};
}

TEST(Coverage, OverlappingRectanglesCountOnce) {
    EXPECT_EQ(unionShare({}), 0.0);
    const ScreenBox quarter = rectangle(-1, -1, 0, 0);
    EXPECT_NEAR(unionShare(std::array{quarter}), 0.25, 1e-12);
    EXPECT_NEAR(unionShare(std::array{quarter, quarter, quarter}), 0.25, 1e-12);
    EXPECT_NEAR(unionShare(std::array{quarter, rectangle(0, 0, 1, 1)}), 0.5, 1e-12);
    EXPECT_NEAR(unionShare(std::array{quarter, rectangle(-0.5, -1, 1, 0)}), 0.5, 1e-12);
    EXPECT_NEAR(unionShare(std::array{rectangle(-1, -1, 1, 1), quarter}), 1.0, 1e-12);
    // Finer than a cell: their sum.
    EXPECT_NEAR(unionShare(std::array{rectangle(0.001, 0.001, 0.002, 0.003)}), 0.25 * 2e-6, 1e-12);
    // Outside, upside down, empty: nothing.
    EXPECT_EQ(unionShare(std::array{ScreenBox{}}), 0.0);
}

// A picture 20 metres high at a distance of 10.
View squareView() {
    FrameRequest request = lookingFrom({0, 0, 10});
    request.camera.yfov = glm::half_pi<double>();
    return *planOf(boxScene(), request).passes.at(1).view();
}
constexpr double kAspect = 160.0 / 90.0;

TEST(Coverage, FlatFiguresParallelToTheImageScaleWithTheProjection) {
    const View view = squareView();
    // A square of 1 at 10 metres, in a picture 20 metres high there.
    Bounds box;
    box.add(Bounds{{-0.5f, -0.5f, -10.0f}, {0.5f, 0.5f, -10.0f}});
    const Plane facing{{0, 0, 1}, 10.0};
    const FlatExtent extent = flatExtent(view, box, facing);
    EXPECT_NEAR(extent.area, 1.0, 1e-4);
    EXPECT_NEAR(extent.share, 1.0 / (20.0 * 20.0 * kAspect), 1e-7);
    EXPECT_NEAR(flatExtent(view, box, {{0, 1, 0}, 0.0}).share, 0.0, 1e-12) << "edge-on";
    EXPECT_EQ(flatExtent(view, box, {{0, 0, 1}, 5.0}).area, 0.0) << "does not meet the plane";
    EXPECT_EQ(flatExtent(view, {{-1, -1, 9}, {1, 1, 9}}, {{0, 0, 1}, -9.0}).share, 0.0)
        << "behind the eye";
}

TEST(Coverage, AFloorBelowTheEyeCoversThePictureUpToTheHorizon) {
    const View view = squareView();
    const Bounds floor{{-1e4f, -1.0f, -1e4f}, {1e4f, -1.0f, 1e4f}};
    const FlatExtent extent = flatExtent(view, floor, {{0, 1, 0}, 1.0});
    EXPECT_NEAR(extent.area, 4e8, 1e4);
    EXPECT_NEAR(extent.share, 0.5, 1e-3);
}

// A right triangle has half of the area of its box.
TEST(Coverage, FlatSurfacesFillTheirBoxesInPart) {
    const auto shareOf = [](bool square) {
        Scene scene;
        MeshDraft draft{.name = "mirror", .hasNormals = true};
        for (const glm::vec3& at :
             {glm::vec3(-1, -1, 0), glm::vec3(1, -1, 0), glm::vec3(-1, 1, 0), glm::vec3(1, 1, 0)}) {
            draft.vertices.push_back({.position = at, .normal = {0, 0, 1}});
        }
        draft.indices = {0, 1, 2};
        if (square) draft.indices.insert(draft.indices.end(), {2, 1, 3});
        draft.material = addMaterial(scene, mirror());
        place(scene, addMesh(scene, std::move(draft)), glm::dvec3(0.0));
        const FramePlan plan = planOf(scene, lookingFrom({0, 0, 5}));
        return plan.decisions.empty() ? 0.0 : plan.decisions[0].share;
    };
    const double height = 10.0 * std::tan(0.45);  // of the picture at the mirror, metres
    EXPECT_NEAR(shareOf(true), kFlatUnhidden * 4.0 / (height * height * kAspect), 0.01);
    EXPECT_NEAR(shareOf(false), 0.5 * shareOf(true), 0.01);
}

TEST(Coverage, AreasScaleWithTransforms) {
    const glm::dmat4 wide = glm::scale(glm::dmat4(1.0), glm::dvec3(3, 2, 5));
    EXPECT_NEAR(transformedArea(wide, 2.0, glm::dvec3(0, 0, 1)), 12.0, 1e-12);
    EXPECT_NEAR(transformedArea(wide, 2.0, glm::dvec3(1, 0, 0)), 20.0, 1e-12);
    const glm::dmat4 twice = glm::scale(glm::dmat4(1.0), glm::dvec3(2.0));
    EXPECT_NEAR(transformedArea(twice, 2.0, std::nullopt), 8.0, 1e-12);
    const glm::dmat4 flat = glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, 0));
    EXPECT_NEAR(transformedArea(flat, 1.0, glm::dvec3(0, 0, 1)), 1.0, 1e-12);
    EXPECT_EQ(transformedArea(flat, 1.0, glm::dvec3(1, 0, 0)), 0.0);
}

// Twenty shells in one another: the sum of their boxes is several pictures.
TEST(Coverage, OverlappingClustersCountOnce) {
    Scene scene;
    MeshDraft draft{.name = "shells", .hasNormals = true};
    constexpr std::uint32_t kRows = 24, kColumns = 48;
    for (int shell = 0; shell < 20; ++shell) {
        const auto first = static_cast<std::uint32_t>(draft.vertices.size());
        for (std::uint32_t j = 0; j <= kRows; ++j) {
            for (std::uint32_t i = 0; i <= kColumns; ++i) {
                const float theta = glm::pi<float>() * float(j) / float(kRows);
                const float phi = glm::two_pi<float>() * float(i) / float(kColumns);
                const glm::vec3 n(std::sin(theta) * std::sin(phi), std::cos(theta),
                                  std::sin(theta) * std::cos(phi));
                draft.vertices.push_back(
                    {.position = n * (1.0f - 0.01f * float(shell)), .normal = n});
            }
        }
        for (std::uint32_t j = 0; j < kRows; ++j) {
            for (std::uint32_t i = 0; i < kColumns; ++i) {
                const std::uint32_t a = first + j * (kColumns + 1) + i, b = a + kColumns + 1;
                draft.indices.insert(draft.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
            }
        }
    }
    const Index material = addMaterial(scene, {.metallic = 1.0f, .roughness = 0.0f});
    draft.material = material;
    place(scene, addMesh(scene, std::move(draft)), glm::dvec3(0.0));
    const FramePlan plan = planOf(scene, lookingFrom({0, 0, 5}));
    ASSERT_EQ(plan.decisions.size(), 1u) << toText(plan);
    // The ball itself: of 160 x 90 pixels with a field of view of 0.9.
    const double radius = std::tan(std::asin(0.2)) / std::tan(0.45);  // of half the height
    const double truth = glm::pi<double>() * radius * radius / 4.0 / (160.0 / 90.0);
    const double said = std::stod(plan.decisions[0].reason) / 100.0;
    EXPECT_GT(said, 0.7 * truth);
    EXPECT_LT(said, 1.6 * truth) << plan.decisions[0].reason;
}

}  // namespace
}  // namespace clerestory::test
