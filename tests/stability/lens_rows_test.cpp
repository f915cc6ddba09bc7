// Rows about lenses: fields of view, poles, folds, coefficients and frames at their limits.
#include "plan/lens/lens.h"
#include "tests/stability/frames.h"

#include <numbers>
#include <random>

namespace clerestory::test {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

FrameRequest lensRequest() {
    FrameRequest r = byPictures(floorScene(glm::dmat4(1.0), false, true), "lensRows", {});
    r.camera.position = glm::dvec3(0.3, -1.6, 0.9);
    r.camera.target = glm::dvec3(0.0, 0.0, 0.2);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov.reset();
    r.width = 24;
    r.height = 18;
    return r;
}

// Draws the frame, or counts a refusal that names another field than one of the lens.
bool drawnOrRefused(const FrameRequest& request) {
    try {
        drawn(request);
        return true;
    } catch (const InvalidRequest& e) {
        const bool named = e.errors()[0].pointer.starts_with("/camera/lens/");
        EXPECT_TRUE(atMost("lenses", "refusals that do not name the lens", !named, 0.0))
            << e.what();
        return false;
    }
}

TEST_F(FrameRows, LensesAtEveryFieldOfView) {
    FrameRequest r = lensRequest();
    for (int i = 0; i <= steps(12, 90); ++i) {
        const double share = double(i) / steps(12, 90);
        r.camera.lens = FisheyeLens{.fov = 0.0174532925 + share * (kTurn - 0.0174532925)};
        EXPECT_TRUE(atMost("lenses", "fisheyes refused", !drawnOrRefused(r), 0.0));
        r.camera.lens =
            EquirectangularLens{1e-3 + share * (kTurn - 1e-3), 1e-3 + share * (0.5 * kTurn - 1e-3)};
        EXPECT_TRUE(atMost("lenses", "panoramas refused", !drawnOrRefused(r), 0.0));
    }
}

TEST_F(FrameRows, LensesOfFramesOfEveryShape) {
    FrameRequest r = lensRequest();
    for (const auto& [width, height] : {std::pair{1u, 1u}, std::pair{1u, 33u}, std::pair{33u, 1u},
                                        std::pair{2u, 3u}, std::pair{7u, 5u}}) {
        r.width = width;
        r.height = height;
        for (const LensRequest& lens :
             {LensRequest(FisheyeLens{}), LensRequest(EquirectangularLens{}),
              LensRequest(CubeLens{}), LensRequest(CubeLens{CubeLayout::row}),
              LensRequest(CubeLens{CubeLayout::cross}),
              LensRequest(PerspectiveLens{.k1 = 0.05})}) {
            r.camera.lens = lens;
            EXPECT_TRUE(atMost("lenses", "small frames refused", !drawnOrRefused(r), 0.0));
        }
    }
}

// Straight up and down, a panorama's poles are ahead: they show one thing in a whole row.
TEST_F(FrameRows, PolesOfPanoramas) {
    FrameRequest r = lensRequest();
    r.width = 64;
    r.height = 32;
    r.camera.lens = EquirectangularLens{};
    const Image image = drawn(r);
    const Lens lens = lensFor(*r.camera.lens, {}, r.width, r.height);
    for (const std::uint32_t row : {0u, 31u}) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const auto ray = rayOf(lens, {x + 0.5, row + 0.5});
            EXPECT_TRUE(atMost("lenses", "angle of the last row from a pole, radians",
                               std::acos(std::abs(ray->y)), std::numbers::pi / 64 + 1e-9));
        }
    }
    EXPECT_EQ(image.width, 64u);
    r.camera.target = *r.camera.position + glm::dvec3(0, 0, 1);
    drawn(r);
    r.camera.target = *r.camera.position - glm::dvec3(0, 0, 1);
    drawn(r);
}

TEST_F(FrameRows, DistortionOfEverySize) {
    FrameRequest r = lensRequest();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-6.0, 6.0);
    const auto coefficient = [&] {
        const double size = std::pow(10.0, exponent(random));
        return random() % 3 == 0 ? 0.0 : random() % 2 ? size : -size;
    };
    int accepted = 0, refused = 0;
    for (int i = 0; i < steps(40, 400); ++i) {
        r.camera.intrinsics = Intrinsics{std::pow(10.0, 0.5 * exponent(random) + 1.5), 20.0, 12.0,
                                         random() % 4 ? 9.0 : 1e5};
        if (i % 2)
            r.camera.lens = PerspectiveLens{coefficient(), coefficient(), coefficient(),
                                            coefficient(), coefficient()};
        else
            r.camera.lens =
                FisheyeLens{.k1 = coefficient(), .k2 = coefficient(), .k3 = coefficient()};
        (drawnOrRefused(r) ? accepted : refused)++;
    }
    EXPECT_GT(refused, 0);
    EXPECT_GT(accepted, 0);
}

TEST_F(FrameRows, PixelsAndRaysOfLenses) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> k(-0.3, 0.3), share(0.0, 1.0);
    for (int i = 0; i < steps(200, 5000); ++i) {
        const Intrinsics in{400 + 600 * share(random), 400 + 600 * share(random), 320, 240};
        const LensRequest models[] = {
            PerspectiveLens{k(random), k(random), k(random), 0.05 * k(random), 0.05 * k(random)},
            FisheyeLens{.k1 = 0.2 * k(random), .k2 = 0.05 * k(random)}, EquirectangularLens{},
            CubeLens{}};
        for (const LensRequest& model : models) {
            const bool focal = std::holds_alternative<PerspectiveLens>(model) ||
                               std::holds_alternative<FisheyeLens>(model);
            try {
                const Lens lens =
                    lensFor(model, focal ? std::optional(in) : std::nullopt, 640, 480);
                for (int j = 0; j < 20; ++j) {
                    const glm::dvec2 pixel(640 * share(random), 480 * share(random));
                    const auto ray = rayOf(lens, pixel);
                    if (!ray) continue;
                    const auto back = pixelOf(lens, *ray);
                    EXPECT_TRUE(atMost("lenses", "pixel to ray to pixel, pixels",
                                       back ? glm::length(*back - pixel) : 1.0, 1e-9));
                }
            } catch (const InvalidRequest&) {
            }
        }
    }
}

}  // namespace
}  // namespace clerestory::test
