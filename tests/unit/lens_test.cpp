// Lenses: known directions at known pixels, OpenCV's formulae worked out by hand, and that a pixel
// and its ray belong together to the precision of the numbers.
#include "plan/lens/lens.h"
#include "plan/lens/distortion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace clerestory::test {
namespace {

using testing::HasSubstr;

constexpr double kHalfCircle = std::numbers::pi;

Lens lens(LensRequest model, std::uint32_t width, std::uint32_t height,
          std::optional<Intrinsics> intrinsics = {}) {
    return lensFor(model, intrinsics, width, height);
}

void expectNear(const std::optional<glm::dvec3>& actual, const glm::dvec3& expected,
                double tolerance = 1e-12) {
    ASSERT_TRUE(actual.has_value());
    EXPECT_LT(glm::length(*actual - expected), tolerance)
        << actual->x << " " << actual->y << " " << actual->z;
}
void expectNear(const std::optional<glm::dvec2>& actual, const glm::dvec2& expected,
                double tolerance = 1e-9) {
    ASSERT_TRUE(actual.has_value());
    EXPECT_LT(glm::length(*actual - expected), tolerance) << actual->x << " " << actual->y;
}

// A pixel's ray leads back to the pixel, and the ray of a direction's pixel is the direction.
void expectRoundTrips(const Lens& l, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> x(0.0, l.width), y(0.0, l.height);
    const double scale = std::max(l.width, l.height);
    for (int i = 0; i < count; ++i) {
        const glm::dvec2 pixel(x(random), y(random));
        const auto ray = rayOf(l, pixel);
        if (!ray) continue;
        EXPECT_NEAR(glm::length(*ray), 1.0, 1e-14);
        const auto back = pixelOf(l, *ray);
        ASSERT_TRUE(back.has_value()) << pixel.x << " " << pixel.y;
        EXPECT_LT(glm::length(*back - pixel), 1e-9 * scale) << pixel.x << " " << pixel.y;
        const auto again = rayOf(l, *back);
        ASSERT_TRUE(again.has_value());
        EXPECT_LT(glm::length(*again - *ray), 1e-9) << pixel.x << " " << pixel.y;
    }
}

// The refused field and its texts.
FieldError refusal(LensRequest model, std::uint32_t width, std::uint32_t height,
                   std::optional<Intrinsics> intrinsics = {}) {
    try {
        lensFor(model, intrinsics, width, height);
    } catch (const InvalidRequest& e) {
        return e.errors().at(0);
    }
    ADD_FAILURE() << "the lens was accepted";
    return {};
}

// ---- panoramas -----------------------------------------------------------------------------

TEST(Lens, AnEquirectangularPictureShowsTheAxesWhereTheyAre) {
    const Lens l = lens(EquirectangularLens{}, 360, 180);
    expectNear(rayOf(l, {180, 90}), {0, 0, -1});
    expectNear(rayOf(l, {270, 90}), {1, 0, 0});
    expectNear(rayOf(l, {90, 90}), {-1, 0, 0});
    expectNear(rayOf(l, {0, 90}), {0, 0, 1});
    expectNear(rayOf(l, {360, 90}), {0, 0, 1});
    for (const double x : {0.0, 77.0, 360.0}) {
        expectNear(rayOf(l, {x, 0}), {0, 1, 0});
        expectNear(rayOf(l, {x, 180}), {0, -1, 0});
    }
    // 30 degrees to the right, 45 up: one degree for each pixel.
    expectNear(rayOf(l, {210, 45}),
               {std::sqrt(0.5) * 0.5, std::sqrt(0.5), -std::sqrt(0.5) * std::sqrt(0.75)});
    expectNear(pixelOf(l, {3.0, 0.0, 0.0}), {270, 90});
    expectNear(pixelOf(l, {0.0, 2.0, -2.0}), {180, 45});
    // A part of it.
    const Lens part = lens(EquirectangularLens{std::numbers::pi / 2, std::numbers::pi / 3}, 90, 60);
    expectNear(rayOf(part, {90, 30}), {std::sqrt(0.5), 0, -std::sqrt(0.5)});
    expectNear(rayOf(part, {45, 0}), {0, 0.5, -std::sqrt(0.75)});
}

TEST(Lens, TheFacesOfACubeAreOrdinaryPictures) {
    const Lens grid = lens(CubeLens{}, 300, 200);
    expectNear(rayOf(grid, {50, 50}), {1, 0, 0});
    expectNear(rayOf(grid, {150, 50}), {-1, 0, 0});
    expectNear(rayOf(grid, {250, 50}), {0, 1, 0});
    expectNear(rayOf(grid, {50, 150}), {0, -1, 0});
    expectNear(rayOf(grid, {150, 150}), {0, 0, 1});
    expectNear(rayOf(grid, {250, 150}), {0, 0, -1});
    // Top right of each face: what is up in it, and right of it.
    const double third = 1.0 / std::sqrt(3.0), e = 1e-9;
    expectNear(rayOf(grid, {100 - e, e}), third * glm::dvec3(1, 1, 1), 1e-9);
    expectNear(rayOf(grid, {200 - e, e}), third * glm::dvec3(-1, 1, -1), 1e-9);
    expectNear(rayOf(grid, {300 - e, e}), third * glm::dvec3(1, 1, 1), 1e-9);
    expectNear(rayOf(grid, {100 - e, 100 + e}), third * glm::dvec3(1, -1, -1), 1e-9);
    expectNear(rayOf(grid, {200 - e, 100 + e}), third * glm::dvec3(-1, 1, 1), 1e-9);
    expectNear(rayOf(grid, {300 - e, 100 + e}), third * glm::dvec3(1, 1, -1), 1e-9);
    const Lens row = lens(CubeLens{CubeLayout::row}, 60, 10);
    expectNear(rayOf(row, {55, 5}), {0, 0, -1});
    const Lens cross = lens(CubeLens{CubeLayout::cross}, 400, 300);
    expectNear(rayOf(cross, {150, 150}), {0, 0, -1});
    expectNear(rayOf(cross, {150, 50}), {0, 1, 0});
    expectNear(rayOf(cross, {350, 150}), {0, 0, 1});
    EXPECT_FALSE(rayOf(cross, {50, 50}).has_value());
    EXPECT_FALSE(rayOf(cross, {350, 299}).has_value());
}

TEST(Lens, TheCrossIsContinuousWhereItsFacesTouch) {
    const Lens cross = lens(CubeLens{CubeLayout::cross}, 400, 300);
    const double e = 1e-7;
    for (const auto& [a, b] : {std::pair<glm::dvec2, glm::dvec2>{{100 - e, 130}, {100 + e, 130}},
                               {{200 - e, 177}, {200 + e, 177}},
                               {{300 - e, 120}, {300 + e, 120}},
                               {{130, 100 - e}, {130, 100 + e}},
                               {{170, 200 - e}, {170, 200 + e}}}) {
        expectNear(rayOf(cross, a), *rayOf(cross, b), 1e-8);
    }
}

// ---- fisheye -------------------------------------------------------------------------------

TEST(Lens, AnEquidistantFisheyeCountsAngles) {
    const Lens l = lens(FisheyeLens{}, 400, 200);  // half a turn over 200 pixels
    expectNear(rayOf(l, {200, 100}), {0, 0, -1});
    expectNear(rayOf(l, {300, 100}), {1, 0, 0});
    expectNear(rayOf(l, {200, 0}), {0, 1, 0});
    expectNear(rayOf(l, {150, 100}), {-std::sqrt(0.5), 0, -std::sqrt(0.5)});
    EXPECT_FALSE(rayOf(l, {300.01, 100}).has_value());
    EXPECT_FALSE(pixelOf(l, {1, 0, 0.01}).has_value());
    // Beyond half a turn it sees what is behind the camera.
    const Lens whole = lens(FisheyeLens{2.0 * std::numbers::pi}, 200, 200);
    expectNear(rayOf(whole, {150, 100}), {1, 0, 0});
    expectNear(rayOf(whole, {200, 100}), {0, 0, 1});
    expectNear(pixelOf(whole, {0, 1, 1}), {100, 25});
}

TEST(Lens, OpenCvsFisheyeFormulaWorkedOutByHand) {
    const FisheyeLens model{.k1 = 0.1, .k2 = -0.02, .k3 = 0.004, .k4 = -0.0005};
    const Intrinsics i{300, 310, 320, 240, PixelCenter::half};
    const Lens l = lens(model, 640, 480, i);
    // 45 degrees to the right: theta_d = 0.8285490436734081.
    expectNear(pixelOf(l, {1, 0, -1}), {568.5647131020224, 240});
    // OpenCV's x = 0.3, y = 0.4 (down), z = 1: r = 0.5, theta_d = 0.4732040097412279.
    expectNear(pixelOf(l, {0.3, -0.4, -1}),
               {320 + 300 * 0.4732040097412279 * 0.6, 240 + 310 * 0.4732040097412279 * 0.8});
    expectNear(
        rayOf(l, {320 + 300 * 0.4732040097412279 * 0.6, 240 + 310 * 0.4732040097412279 * 0.8}),
        glm::normalize(glm::dvec3(0.3, -0.4, -1)));
}

// ---- Brown and Conrady ---------------------------------------------------------------------

TEST(Lens, OpenCvsDistortionFormulaWorkedOutByHand) {
    const PerspectiveLens model{.k1 = -0.28, .k2 = 0.07, .k3 = -0.005, .p1 = 0.001, .p2 = -0.0005};
    const Lens l = lens(model, 640, 480, Intrinsics{500, 510, 320, 240, PixelCenter::half});
    // x = 0.4, y = -0.3: r^2 = 0.25, radial factor 0.934296875; x'' = 0.37319375,
    // y'' = -0.2797390625.
    expectNear(pixelOf(l, {0.4, 0.3, -1}), {506.596875, 97.333078125});
    expectNear(rayOf(l, {506.596875, 97.333078125}), glm::normalize(glm::dvec3(0.4, 0.3, -1)));
    // OpenCV's coordinates of pixel centres are whole numbers.
    const Lens whole =
        lens(model, 640, 480, Intrinsics{500, 510, 319.5, 239.5, PixelCenter::integer});
    EXPECT_EQ(whole, l);
}

TEST(Lens, WithoutCoefficientsNoLensIsNeeded) {
    EXPECT_FALSE(needsLens(PerspectiveLens{}));
    EXPECT_FALSE(needsLens(OrthographicLens{2.0}));
    EXPECT_TRUE(needsLens(PerspectiveLens{.p2 = 1e-9}));
    EXPECT_TRUE(needsLens(EquirectangularLens{}));
    EXPECT_TRUE(needsLens(CubeLens{}));
    EXPECT_TRUE(needsLens(FisheyeLens{}));
}

// ---- inverses ------------------------------------------------------------------------------

TEST(Lens, PixelsAndRaysAreInversesOfEachOther) {
    expectRoundTrips(lens(EquirectangularLens{}, 1280, 720), 2000, 1);
    expectRoundTrips(lens(EquirectangularLens{0.7, 2.0}, 333, 777), 2000, 2);
    for (const CubeLayout layout : {CubeLayout::grid, CubeLayout::row, CubeLayout::cross}) {
        expectRoundTrips(lens(CubeLens{layout}, 1200, 900), 2000, 3);
    }
    expectRoundTrips(lens(FisheyeLens{}, 1280, 720), 2000, 4);
    expectRoundTrips(lens(FisheyeLens{1.99 * std::numbers::pi}, 64, 48), 2000, 5);
}

TEST(Lens, TheInverseOfDistortionIsExactForRandomCoefficients) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> k(-0.5, 0.5), p(-0.02, 0.02), f(200.0, 2000.0);
    int accepted = 0;
    for (int i = 0; i < 300; ++i) {
        const PerspectiveLens model{k(random), k(random), k(random), p(random), p(random)};
        const Intrinsics in{f(random), f(random), 320 + 50 * k(random), 240 + 50 * k(random),
                            PixelCenter::half};
        try {
            expectRoundTrips(lens(model, 640, 480, in), 100, static_cast<std::uint32_t>(i));
            ++accepted;
        } catch (const InvalidRequest&) {
        }
    }
    EXPECT_GT(accepted, 100);
}

TEST(Lens, TheInverseOfTheFisheyeIsExactForRandomCoefficients) {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> k(-0.05, 0.05), fov(0.1, 2.0 * std::numbers::pi);
    int accepted = 0;
    for (int i = 0; i < 300; ++i) {
        FisheyeLens model{fov(random), k(random), k(random), 0.1 * k(random), 0.01 * k(random)};
        try {
            expectRoundTrips(lens(model, 640, 480), 100, static_cast<std::uint32_t>(i));
            ++accepted;
        } catch (const InvalidRequest&) {
        }
    }
    EXPECT_GT(accepted, 100);
}

// r (1 + k1 r^2) with k1 < 0 has its greatest value at r = 1 / sqrt(-3 k1).
TEST(Lens, TheInverseHoldsUpToTheLastRadius) {
    const PerspectiveLens model{.k1 = -1.0 / 3.0};
    const double radius = injectiveRadius(model);
    EXPECT_NEAR(radius, 1.0, 1e-3);  // where the slope is not 0 but kLeastStretch
    EXPECT_LT(radius, 1.0);
    for (const double share : {0.5, 0.9, 0.99, 0.999999, 1.0}) {
        const glm::dvec2 at = share * radius * glm::dvec2(0.6, -0.8);
        const auto back = undistorted(model, distorted(model, at), radius);
        ASSERT_TRUE(back.has_value()) << share;
        EXPECT_LT(glm::length(*back - at), 1e-12) << share;
    }
    EXPECT_FALSE(undistorted(model, {0.7, 0.0}, radius).has_value()) << "more than 2/3";
    const FisheyeLens fisheye{.k1 = -1.0 / 3.0};  // theta - theta^3 / 3
    const double most = injectiveAngle(fisheye);
    EXPECT_NEAR(most, 1.0, 1e-3);
    EXPECT_NEAR(undistortedAngle(fisheye, distortedAngle(fisheye, 0.999 * most), most),
                0.999 * most, 1e-12);
}

// ---- limits --------------------------------------------------------------------------------

TEST(Lens, DistortionThatFoldsTheFrameIsRefusedWithItsRadius) {
    // Invertible up to r = 1, which is shown at 2/3: 400 pixels from the centre at f = 600.
    const FieldError error = refusal(PerspectiveLens{.k1 = -1.0 / 3.0}, 1280, 720,
                                     Intrinsics{600, 600, 640, 360, PixelCenter::half});
    EXPECT_EQ(error.pointer, "/camera/lens/k1");
    EXPECT_THAT(error.detail, HasSubstr("up to a radius of 400 pixels"));
    EXPECT_THAT(error.detail, HasSubstr("the frame reaches 734.3"));
    // The same lens on a smaller frame.
    lens(PerspectiveLens{.k1 = -1.0 / 3.0}, 640, 460,
         Intrinsics{600, 600, 320, 230, PixelCenter::half});
    const Intrinsics wide{300, 300, 320, 240, PixelCenter::half};
    EXPECT_EQ(refusal(PerspectiveLens{.k2 = -1.0}, 640, 480, wide).pointer, "/camera/lens/k2");
    EXPECT_EQ(refusal(PerspectiveLens{.k3 = -1.0}, 640, 480, wide).pointer, "/camera/lens/k3");
    EXPECT_EQ(refusal(PerspectiveLens{.p1 = 0.5}, 640, 480, wide).pointer, "/camera/lens/p1");
    EXPECT_EQ(refusal(PerspectiveLens{.p2 = -0.5}, 640, 480, wide).pointer, "/camera/lens/p2");
}

TEST(Lens, AFisheyeThatFoldsIsRefused) {
    const FieldError given =
        refusal(FisheyeLens{.fov = std::numbers::pi, .k1 = -1.0 / 3.0}, 640, 480);
    EXPECT_EQ(given.pointer, "/camera/lens/fov");
    EXPECT_THAT(given.allowed, HasSubstr("at most 1.99"));
    EXPECT_EQ(refusal(FisheyeLens{.k2 = -0.2}, 640, 480).pointer, "/camera/lens/k2");
    const Intrinsics i{300, 300, 320, 240, PixelCenter::half};  // corners at 400 pixels
    const FieldError corners = refusal(FisheyeLens{.k1 = -1.0 / 3.0}, 640, 480, i);
    EXPECT_EQ(corners.pointer, "/camera/lens/k1");
    EXPECT_THAT(corners.detail, HasSubstr("up to a radius of 200 pixels"));
    // The image circle within it is accepted, and black outside.
    const Lens circle = lens(FisheyeLens{.fov = 1.5, .k1 = -1.0 / 3.0}, 640, 480, i);
    EXPECT_TRUE(rayOf(circle, {320, 240}).has_value());
    EXPECT_FALSE(rayOf(circle, {0, 0}).has_value());
}

TEST(Lens, HugeCoefficientsAndTinyFramesStayFinite) {
    std::mt19937 random(13);
    std::uniform_int_distribution<int> which(-2, 2);
    const double sizes[] = {0.0, 1e-9, 1.0, 1e6};
    const auto coefficient = [&] { return which(random) * sizes[random() % 4]; };
    for (int i = 0; i < 500; ++i) {
        const std::uint32_t width = 1 + random() % 3, height = 1 + random() % 3;
        const Intrinsics in{1e-3, 1e7, -1e6, 1e6, PixelCenter::integer};
        const std::optional<Intrinsics> intrinsics = i % 2 ? std::optional(in) : std::nullopt;
        const LensRequest models[] = {
            PerspectiveLens{coefficient(), coefficient(), coefficient(), coefficient(),
                            coefficient()},
            FisheyeLens{i % 3 ? std::nullopt : std::optional(kHalfCircle), coefficient(),
                        coefficient(), coefficient(), coefficient()}};
        for (const LensRequest& model : models) {
            try {
                const Lens l =
                    lens(model, width, height,
                         std::holds_alternative<PerspectiveLens>(model) ? in : intrinsics);
                if (const auto ray = rayOf(l, {0.5, 0.5})) {
                    EXPECT_NEAR(glm::length(*ray), 1.0, 1e-9);
                }
            } catch (const InvalidRequest&) {
            }
        }
    }
}

}  // namespace
}  // namespace clerestory::test
