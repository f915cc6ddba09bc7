// Frames of lenses: which views they are assembled from, that every pixel of the frame reads a view
// that shows it, and plans that are the same as ever without a lens.
#include "view_planner_support.h"

#include "plan/graph/work.h"
#include "plan/lens/tiles.h"
#include "plan/visibility/view.h"
#include "scene/fit.h"

#include <cmath>
#include <numbers>
#include <random>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

FrameRequest withLens(FrameRequest request, LensRequest lens) {
    request.camera.lens = std::move(lens);
    return request;
}

std::vector<std::string> namesOf(const std::vector<LensTile>& tiles) {
    std::vector<std::string> names;
    for (const LensTile& tile : tiles) names.push_back(tile.name);
    return names;
}

std::vector<LensTile> tiles(const LensRequest& model, std::uint32_t width, std::uint32_t height,
                            std::optional<Intrinsics> intrinsics = {}) {
    return tilesOf(lensFor(model, intrinsics, width, height));
}

Intrinsics centred(double focal, std::uint32_t width, std::uint32_t height) {
    return {focal, focal, 0.5 * width, 0.5 * height, PixelCenter::half};
}

// ---- tiles ---------------------------------------------------------------------------------

TEST(LensTiles, OnlyFacesThatTheLensShowsAreDrawn) {
    EXPECT_THAT(namesOf(tiles(EquirectangularLens{}, 320, 160)),
                UnorderedElementsAre("front", "left", "right", "back", "up", "down"));
    EXPECT_THAT(namesOf(tiles(CubeLens{}, 96, 64)),
                UnorderedElementsAre("front", "left", "right", "back", "up", "down"));
    EXPECT_THAT(namesOf(tiles(FisheyeLens{}, 320, 240)),
                UnorderedElementsAre("front", "left", "right", "up", "down"));
    EXPECT_THAT(namesOf(tiles(FisheyeLens{2.0 * std::numbers::pi}, 320, 240)),
                UnorderedElementsAre("front", "left", "right", "up", "down", "back"));
    // A strip around the horizon.
    EXPECT_THAT(namesOf(tiles(EquirectangularLens{2.0 * std::numbers::pi, 0.8}, 320, 60)),
                UnorderedElementsAre("front", "left", "right", "back"));
    EXPECT_THAT(namesOf(tiles(EquirectangularLens{3.0, 0.8}, 320, 60)),
                UnorderedElementsAre("front", "left", "right"));
    // Narrow ones need one view.
    EXPECT_THAT(namesOf(tiles(FisheyeLens{1.6}, 320, 240)), ElementsAre("front"));
    EXPECT_THAT(namesOf(tiles(EquirectangularLens{1.5, 1.0}, 320, 240)), ElementsAre("front"));
    EXPECT_THAT(
        namesOf(tiles(PerspectiveLens{.k1 = -0.2, .k2 = 0.05}, 320, 240, centred(250, 320, 240))),
        ElementsAre("front"));
}

TEST(LensTiles, FacesOfACubeHaveOneTexelForEachPixel) {
    for (const LensTile& tile : tiles(CubeLens{}, 300, 200)) {
        EXPECT_DOUBLE_EQ(tile.pinhole.fx, 50.0) << tile.name;
        EXPECT_EQ(tile.width, 112u) << "100 and 6 on each side";
        EXPECT_EQ(tile.height, 112u);
        EXPECT_DOUBLE_EQ(tile.pinhole.cx, 56.0);
        EXPECT_DOUBLE_EQ(tile.pinhole.cy, 56.0);
    }
}

// The lookups of a lens lead to the directions of the pixels, with weights that add up to 1, within
// the tiles; no texel is wider than a pixel.
void expectLookupsShowThePixels(const Lens& lens, bool blend) {
    const std::vector<LensTile> tiles = tilesOf(lens);
    const std::vector<TileLookups> lookups = lookupsOf(lens, tiles, blend);
    ASSERT_EQ(lookups.size(), tiles.size());
    std::vector<double> weights(std::size_t{lens.width} * lens.height, 0.0);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const TileLookups& rect = lookups[i];
        const std::vector<glm::vec4>& texels = rect.texels;
        ASSERT_EQ(texels.size(), std::size_t{rect.width} * rect.height);
        for (std::uint32_t y = 0; y < rect.height; ++y) {
            for (std::uint32_t x = 0; x < rect.width; ++x) {
                const glm::vec4& here = texels[std::size_t{y} * rect.width + x];
                if (here.z == 0.0f) continue;
                const std::uint32_t px = rect.x + x, py = rect.y + y;
                weights[std::size_t{py} * lens.width + px] += here.z;
                const auto ray = rayOf(lens, {px + 0.5, lens.height - py - 0.5});
                ASSERT_TRUE(ray.has_value());
                const Intrinsics& p = tiles[i].pinhole;
                const glm::dvec3 local((here.x - p.cx) / p.fx,
                                       (here.y - (tiles[i].height - p.cy)) / p.fy, -1.0);
                const glm::dvec3 shown = tiles[i].cameraFromTile * glm::normalize(local);
                ASSERT_LT(glm::length(shown - *ray), 2e-5) << tiles[i].name << px << " " << py;
                // A texel around it is inside, for bilinear look-ups.
                ASSERT_GE(here.x, 1.0f) << tiles[i].name;
                ASSERT_GE(here.y, 1.0f) << tiles[i].name;
                ASSERT_LE(here.x, tiles[i].width - 1.0f) << tiles[i].name;
                ASSERT_LE(here.y, tiles[i].height - 1.0f) << tiles[i].name;
                const double factor =
                    depthPerDistance(lens, *ray) * glm::length(local);  // per depth in the tile
                ASSERT_NEAR(here.w, factor, 1e-4 * factor);
            }
        }
    }
    for (std::uint32_t y = 0; y < lens.height; ++y) {
        for (std::uint32_t x = 0; x < lens.width; ++x) {
            const bool shows = rayOf(lens, {x + 0.5, lens.height - y - 0.5}).has_value();
            ASSERT_NEAR(weights[std::size_t{y} * lens.width + x], shows ? 1.0 : 0.0, 1e-5)
                << x << " " << y;
        }
    }
}

TEST(LensTiles, EveryPixelReadsAViewThatShowsIt) {
    for (const bool blend : {true, false}) {
        for (const auto& [width, height] :
             {std::pair{160u, 80u}, std::pair{97u, 61u}, std::pair{1u, 1u}, std::pair{1u, 50u},
              std::pair{7u, 3u}, std::pair{300u, 200u}}) {
            const auto check = [&](const LensRequest& model, std::optional<Intrinsics> in = {}) {
                SCOPED_TRACE(std::string(typeOf(model)) + " " + std::to_string(width));
                expectLookupsShowThePixels(lensFor(model, in, width, height), blend);
            };
            check(EquirectangularLens{});
            check(EquirectangularLens{1.0, 3.0});
            check(CubeLens{});
            check(CubeLens{CubeLayout::cross});
            for (const double fov :
                 {0.1, 1.5, 1.58, 1.7, 2.0, 3.0, std::numbers::pi, 4.0, 5.5, 6.28}) {
                check(FisheyeLens{fov});
            }
            check(FisheyeLens{.k1 = 0.05, .k2 = -0.001}, centred(0.3 * width, width, height));
            check(PerspectiveLens{.k1 = -0.2, .k2 = 0.05, .p1 = 0.001},
                  centred(0.7 * width + 0.5 * height, width, height));
            check(PerspectiveLens{.k1 = 0.5}, centred(0.2 * width, width, height));
        }
    }
}

TEST(LensTiles, RandomLensesShowEveryPixel) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> k(-0.1, 0.1), fov(0.05, 2.0 * std::numbers::pi),
        focal(0.15, 3.0);
    int accepted = 0;
    for (int i = 0; i < 60; ++i) {
        const std::uint32_t width = 1 + random() % 120, height = 1 + random() % 120;
        const Intrinsics in{focal(random) * width, focal(random) * width,
                            0.5 * width + 200 * k(random), 0.5 * height + 200 * k(random),
                            PixelCenter::half};
        const LensRequest models[] = {
            FisheyeLens{fov(random), k(random), 0.1 * k(random)},
            FisheyeLens{.k1 = std::abs(k(random))},
            PerspectiveLens{k(random), k(random), 0.1 * k(random), 0.05 * k(random)}};
        for (const LensRequest& model : models) {
            try {
                expectLookupsShowThePixels(
                    lensFor(model,
                            i % 2 || std::holds_alternative<PerspectiveLens>(model)
                                ? std::optional(in)
                                : std::nullopt,
                            width, height),
                    true);
                ++accepted;
            } catch (const InvalidRequest&) {
            }
        }
    }
    EXPECT_GT(accepted, 80);
}

// Angles between neighbouring texels, and between neighbouring pixels that read them.
TEST(LensTiles, NoPixelIsFinerThanTheTexelsThatItReads) {
    for (const Lens& lens :
         {lensFor(FisheyeLens{}, {}, 200, 150), lensFor(FisheyeLens{1.4}, {}, 200, 150),
          lensFor(PerspectiveLens{.k1 = -0.25, .k2 = 0.05}, centred(150, 200, 150), 200, 150),
          lensFor(EquirectangularLens{2.0 * std::numbers::pi, 0.5}, {}, 200, 30),
          lensFor(CubeLens{}, {}, 150, 100)}) {
        const auto tiles = tilesOf(lens);
        for (const TileLookups& tile : lookupsOf(lens, tiles, false)) {
            for (std::uint32_t y = 0; y + 1 < tile.height; ++y) {
                for (std::uint32_t x = 0; x + 1 < tile.width; ++x) {
                    const auto at = [&](std::uint32_t px, std::uint32_t py) {
                        return tile.texels[std::size_t{py} * tile.width + px];
                    };
                    const glm::vec4 here = at(x, y);
                    for (const glm::vec4& next : {at(x + 1, y), at(x, y + 1)}) {
                        if (here.z == 0.0f || next.z == 0.0f) continue;
                        EXPECT_GT(glm::length(glm::vec2(next) - glm::vec2(here)), 0.98f);
                    }
                }
            }
        }
    }
}

// ---- plans ---------------------------------------------------------------------------------

TEST(LensPlan, AFrameWithoutALensIsPlannedAsEver) {
    const FrameRequest plain = forced(lookingFrom({0.3, 0.2, 5}));
    const FramePlan plan = planOf(mirrorScene(), plain);
    EXPECT_EQ(count(plan, "lens"), 0u);
    EXPECT_FALSE(plan.lens.has_value());
    EXPECT_EQ(planOf(mirrorScene(), withLens(plain, PerspectiveLens{})), plan);
    FrameRequest orthographic = plain;
    orthographic.camera.orthographicHeight = 3.0;
    EXPECT_EQ(planOf(mirrorScene(), withLens(plain, OrthographicLens{3.0})),
              planOf(mirrorScene(), orthographic));
}

TEST(LensPlan, APanoramaIsSixViewsAndOnePass) {
    const FramePlan plan =
        planOf(boxScene(dullGrey()), withLens(lookingFrom({0, 0, 5}), EquirectangularLens{}));
    EXPECT_EQ(count(plan, "surface"), 6u) << toText(plan);
    EXPECT_EQ(count(plan, "lens"), 1u);
    EXPECT_EQ(totals(plan).views, 6u);
    const Pass lens = passesOf(plan, "lens").at(0);
    EXPECT_EQ(lens.reads().size(), 6u);
    EXPECT_EQ(plan.targets[lens.target].width, plan.width);
    EXPECT_FALSE(plan.targets[lens.target].depth);
    // Its views and pixels are counted, and it comes after all of them.
    std::uint64_t texels = 0;
    for (const Pass& pass : passesOf(plan, "surface")) {
        texels += texelsOf(plan.targets[pass.target], Faces::one, Levels::first);
        EXPECT_THAT(pass.name, HasSubstr("surface:"));
        EXPECT_THAT(pass.reason, HasSubstr("of the lens equirectangular"));
    }
    EXPECT_GE(shadedSamples(plan), texels + std::uint64_t{plan.width} * plan.height);
    ASSERT_TRUE(plan.lens.has_value());
    EXPECT_EQ(frameView(plan), &plan.lens->view);
}

TEST(LensPlan, DistortionAndNarrowFisheyesAreOneView) {
    for (const LensRequest& lens :
         {LensRequest(PerspectiveLens{.k1 = -0.1}), LensRequest(FisheyeLens{1.2})}) {
        const FramePlan plan = planOf(boxScene(dullGrey()), withLens(lookingFrom({0, 0, 5}), lens));
        EXPECT_EQ(count(plan, "surface"), 1u) << toText(plan);
        EXPECT_EQ(count(plan, "lens"), 1u);
    }
}

TEST(LensPlan, MirrorsArePlannedInEachViewThatShowsThem) {
    const FramePlan plan =
        planOf(mirrorScene(), withLens(forced(lookingFrom({0.3, 0.2, 5})), EquirectangularLens{}));
    EXPECT_EQ(count(plan, "mirror"), 1u) << toText(plan);  // only the front view
    FrameRequest close = forced(lookingFrom({0.9, 0.2, 0.5}));
    const FramePlan near = planOf(mirrorScene(), withLens(close, EquirectangularLens{}));
    EXPECT_GT(count(near, "mirror"), 2u) << toText(near);
}

TEST(LensPlan, AllViewsOfALensChooseTheSameMethod) {
    FrameRequest close = lookingFrom({0.9, 0.2, 0.5});
    close.width = 640;
    close.height = 320;
    const FramePlan plan = planOf(mirrorScene(), withLens(close, EquirectangularLens{}));
    std::set<Method> methods;
    std::size_t decisions = 0;
    for (const Decision& d : plan.decisions) {
        if (d.subject.kind != Subject::Kind::mirror) continue;
        methods.insert(d.taken);
        ++decisions;
    }
    EXPECT_GT(decisions, 1u) << toText(plan);
    EXPECT_EQ(methods.size(), 1u) << toText(plan);
}

TEST(LensPlan, ChannelsAreDrawnInEveryViewAndAssembledAsNumbers) {
    for (const Channel channel :
         {Channel::depth, Channel::normal, Channel::objectId, Channel::through}) {
        FrameRequest r = withLens(forced(lookingFrom({0.9, 0.2, 0.5})), FisheyeLens{});
        r.output.channel = channel;
        r.output.format = OutputFormat::npy;
        const FramePlan plan = planOf(mirrorScene(), r);
        EXPECT_EQ(count(plan, "channel"), 5u) << toText(plan);
        EXPECT_EQ(count(plan, "surface"), 0u);
        const auto lens = worksOf<AssembleLens>(plan).at(0);
        EXPECT_TRUE(lens.numbers);
        EXPECT_EQ(lens.depth, channel == Channel::depth);
        EXPECT_EQ(plan.output, passesOf(plan, "lens").at(0).target);
    }
}

// The k-th mirrored view of the plan of the colour, through all views of the lens.
TEST(LensPlan, ThroughNumbersMirroredViewsAcrossTheViewsOfALens) {
    FrameRequest r = withLens(forced(lookingFrom({0.9, 0.2, 0.5})), EquirectangularLens{});
    const FramePlan color = planOf(mirrorScene(), r);
    r.output.channel = Channel::through;
    r.output.format = OutputFormat::npy;
    std::set<std::uint32_t> numbers;
    for (const DrawChannel& work : worksOf<DrawChannel>(planOf(mirrorScene(), r))) {
        for (const Draw& draw : work.draws) {
            if (draw.label.value_or(0) >= throughFirstMirror)
                numbers.insert(*draw.label - throughFirstMirror);
        }
    }
    const std::size_t mirrors = count(color, "mirror");
    ASSERT_GT(mirrors, 1u);
    EXPECT_EQ(numbers.size(), mirrors);
    EXPECT_EQ(*numbers.rbegin(), mirrors - 1);
}

// ---- requests ------------------------------------------------------------------------------

std::vector<std::string> pointersOf(const FrameRequest& request) {
    std::vector<std::string> pointers;
    for (const FieldError& e : problems(request)) pointers.push_back(e.pointer);
    return pointers;
}

TEST(LensRequests, ConflictsNameTheField) {
    FrameRequest r = withLens(lookingFrom({0, 0, 5}), EquirectangularLens{});
    EXPECT_THAT(pointersOf(r), ElementsAre());
    r.camera.yfov = 1.0;
    EXPECT_THAT(pointersOf(r), ElementsAre("/camera/yfov"));
    r.camera.yfov.reset();
    r.camera.intrinsics = Intrinsics{};
    EXPECT_THAT(pointersOf(r), ElementsAre("/camera/intrinsics"));
    r.camera.lens = FisheyeLens{};
    EXPECT_THAT(pointersOf(r), ElementsAre());
    r.camera.intrinsics.reset();
    r.camera.orthographicHeight = 2.0;
    EXPECT_THAT(pointersOf(r), ElementsAre("/camera/orthographicHeight"));
    FrameRequest fitted = withLens({}, CubeLens{});
    fitted.camera.fit = FitRequest{};
    EXPECT_THAT(pointersOf(fitted), ElementsAre("/camera/fit"));
    fitted.camera.lens = PerspectiveLens{.k1 = -0.1};
    EXPECT_THAT(pointersOf(fitted), ElementsAre());
}

// Everything is within the frame, and something is near its border.
TEST(LensRequests, FitUsesTheUndistortedFrame) {
    const Scene scene = boxScene(dullGrey());
    const Pose pose = poseAt(scene, 0.0);
    for (const double k1 : {-0.15, 0.0, 0.2}) {
        CameraRequest camera;
        camera.fit = FitRequest{.margin = 0.05};
        camera.lens = PerspectiveLens{.k1 = k1};
        const View view = requestedView(camera, scene, pose, 300, 200);
        const auto lens = requestedLens(camera, scene, pose, 300, 200);
        EXPECT_EQ(lens.has_value(), k1 != 0.0);
        double least = INFINITY;
        for (const glm::dvec3& corner : cornersOf(scene, pose)) {
            const glm::dvec3 local(view.viewFromWorld * glm::dvec4(corner, 1.0));
            const glm::dvec2 at = lens ? *pixelOf(*lens, local)
                                       : glm::dvec2(150, 100) + 100.0 / std::tan(0.5 * kFitYfov) *
                                                                    glm::dvec2(local.x, -local.y) /
                                                                    -local.z;
            least = std::min({least, at.x - 15.0, 285.0 - at.x, at.y - 10.0, 190.0 - at.y});
        }
        EXPECT_GT(least, -1e-6) << k1;
        EXPECT_LT(least, 12.0) << k1;
    }
}

}  // namespace
}  // namespace clerestory::test
