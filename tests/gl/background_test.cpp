// Backgrounds of one colour and transparent ones. A picture before a colour equals the transparent
// picture laid over that colour.
#include "../support/compare_images.h"
#include "alpha_support.h"
#include "support.h"

#include <algorithm>
#include <cmath>

namespace clerestory::test {
namespace {

using Radiance = std::array<double, 3>;

class BackgroundTest : public GlTest {};

// A ball, a tilted tinted pane, a veil and a solid ball of glass, lit by the studio map.
Scene stillLife(bool glass) {
    Scene s;
    place(s,
          sphere(
              0.5f, 24,
              addMaterial(
                  s, {.baseColor = {0.8f, 0.3f, 0.2f, 1.0f}, .metallic = 0.0f, .roughness = 0.6f})),
          moved(-0.8, -0.2, 0.0));
    place(s, sphere(0.4f, 24, addMaterial(s, mirrorMetal(0.8f))), moved(0.9, 0.6, -0.3));
    Material veil{.baseColor = {0.2f, 0.7f, 0.3f, 0.4f}, .roughness = 0.9f};
    veil.alphaMode = AlphaMode::blend;
    veil.doubleSided = true;
    place(s, quad(0.5f, addMaterial(s, veil)), moved(0.1, -0.7, 0.4));
    if (!glass) return s;
    Material pane = clearGlass();
    pane.baseColor = {0.9f, 0.6f, 0.3f, 1.0f};
    pane.doubleSided = true;
    place(s, quad(0.45f, addMaterial(s, pane)),
          moved(-0.5, 0.6, 0.5) *
              glm::dmat4(glm::mat3_cast(glm::angleAxis(0.6, glm::dvec3(0, 1, 0)))));
    Material ball = clearGlass(1.4f);
    ball.thickness = 0.8f;
    place(s, sphere(0.4f, 32, addMaterial(s, ball)), moved(0.6, -0.3, 0.6));
    return s;
}

FrameRequest stillLifeRequest(bool glass, const std::string& id) {
    FrameRequest r = request(stillLife(glass), id, {0.0, 0.1, 3.0});
    r.width = 160;
    r.height = 120;
    r.camera.yfov = 0.9;
    r.environment.map = "studio";
    r.effects.shadows = r.effects.indirectLight = false;
    return r;
}

constexpr Radiance kGrey{0.5, 0.5, 0.5}, kSand{0.7, 0.55, 0.2};

float srgbOf(float light) {
    const float v = std::clamp(light, 0.0f, 1.0f);
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
}

// With several samples, an edge of a thing that looks like one background has no contrast before
// it, and has before another. So both pictures differ, by less than a contrast that counts.
TEST_F(BackgroundTest, WithSeveralSamplesBothDifferByLessThanAContrast) {
    FrameRequest r = stillLifeRequest(false, "opaque still life");
    r.accuracy.samples = 4;
    r.background = Background::transparent;
    const Image transparent = renderer().render(r).image;
    for (const Radiance& background : {kGrey, kSand}) {
        r.background = background;
        const Image direct = renderer().render(r).image;
        const Image composed = over(transparent, background);
        std::size_t equal = 0;
        for (std::size_t i = 0; i < std::size_t{3} * direct.width * direct.height; ++i) {
            const float a = direct.floats()[i], b = composed.floats()[i];
            equal += std::abs(a - b) < 1e-5f;
            EXPECT_LT(std::abs(srgbOf(a) - srgbOf(b)), 0.15f) << i;
        }
        EXPECT_GT(equal, 0.95 * 3 * direct.width * direct.height);
    }
}

TEST_F(BackgroundTest, APictureBeforeAColourIsTheTransparentOneOverIt) {
    FrameRequest r = stillLifeRequest(false, "opaque still life");
    r.background = Background::transparent;
    renderer().render(r);  // maps are resident from now on
    const Frame transparent = renderer().render(r);
    ASSERT_EQ(transparent.image.channels, 4u);
    for (const Radiance& background : {kGrey, kSand}) {
        r.background = background;
        const Frame direct = renderer().render(r);
        ASSERT_EQ(direct.image.channels, 3u);
        // Half a unit in the last place of a half float, where the target has halves.
        const Tolerance rounding{"sum in floats", 1e-5, 0.0};
        EXPECT_TRUE(imagesMatch(over(transparent.image, background), direct.image, rounding));
        EXPECT_EQ(transparent.plan.passes.size(), direct.plan.passes.size());
        EXPECT_EQ(totals(transparent.plan).draws, totals(direct.plan).draws);
    }
}

// The tint of glass is one colour, alpha one number: grey backgrounds are exact if the mean over
// the channels is compared.
TEST_F(BackgroundTest, WhatGlassLetsThroughIsTheMeanOfItsTint) {
    for (const GlassMethod method : {GlassMethod::backdrop, GlassMethod::traced}) {
        FrameRequest r = stillLifeRequest(true, "glass still life");
        r.accuracy.glass = method;
        r.background = Background::transparent;
        const Image transparent = renderer().render(r).image;
        r.background = Radiance{1.0, 1.0, 1.0};
        const Image white = renderer().render(r).image;
        r.background = Radiance{0.0, 0.0, 0.0};
        const Image black = renderer().render(r).image;
        double worst = 0.0, worstColour = 0.0;
        int partly = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const glm::vec3 through = color(white, x, y) - color(black, x, y);
                const float alpha = transparent.floats()[4 * (std::size_t{y} * r.width + x) + 3];
                worst = std::max(worst,
                                 std::abs(1.0 - alpha - (through.x + through.y + through.z) / 3.0));
                const glm::vec3 apart = color(transparent, x, y) - color(black, x, y);
                worstColour = std::max({worstColour, std::abs(double(apart.x)),
                                        std::abs(double(apart.y)), std::abs(double(apart.z))});
                partly += alpha > 0.05f && alpha < 0.95f;
            }
        }
        EXPECT_LE(worst, 1e-5);
        EXPECT_LE(worstColour, 0.0) << "the picture before black is the premultiplied one";
        EXPECT_GT(partly, 500);
    }
}

// A pane of one colour in front of nothing: (1 - F)/(1 + F) times its tint, by arithmetic.
TEST_F(BackgroundTest, APaneLeavesItsTransmittance) {
    Scene s;
    Material pane = clearGlass();
    pane.baseColor = {0.9f, 0.6f, 0.3f, 1.0f};
    place(s, quad(4.0f, addMaterial(s, pane)));
    for (const GlassMethod method :
         {GlassMethod::environment, GlassMethod::backdrop, GlassMethod::traced}) {
        FrameRequest r = request(s, "pane before nothing");
        r.accuracy.glass = method;
        r.background = Background::transparent;
        const Image image = renderer().render(r).image;
        const double f = 0.04;  // ((1.5 - 1) / (1.5 + 1))^2
        const float* p = image.floats() + 4 * (32u * 64u + 32u);
        EXPECT_NEAR(p[3], 1.0 - 0.6 * (1.0 - f) / (1.0 + f), 2e-4);
        EXPECT_EQ(p[0], 0.0f);
    }
}

TEST_F(BackgroundTest, FilesWithStraightAlphaShowTheSameOverBlackAndGrey) {
    FrameRequest r = stillLifeRequest(false, "straight still life");
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    r.exposure = -1.0;  // nothing brighter than white
    for (const bool edges : {false, true}) {
        r.accuracy.edgeFilter = edges;
        r.background = Background::transparent;
        const Frame frame = renderer().render(r);
        EXPECT_EQ(frame.plan.passes.back().kind(), "straightAlpha");
        EXPECT_EQ(frame.image.type, PixelType::srgb8);
        r.background = Radiance{0.4, 0.4, 0.4};  // 0.2 after the exposure
        const Image direct = renderer().render(r).image;
        const auto linear = [](std::uint8_t code) {
            const double v = code / 255.0;
            return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        };
        double worst = 0.0;
        int soft = 0, far = 0;
        for (std::size_t i = 0; i < std::size_t{r.width} * r.height; ++i) {
            const std::uint8_t* in = frame.image.bytes() + 4 * i;
            const double alpha = in[3] / 255.0;
            soft += in[3] > 10 && in[3] < 245;
            for (std::size_t c = 0; c < 3; ++c) {
                const double laid = alpha * linear(in[c]) + (1.0 - alpha) * 0.2;
                const double error = std::abs(laid - linear(direct.bytes()[4 * i + c]));
                worst = std::max(worst, error);
                far += error > 0.01;
            }
        }
        EXPECT_GT(soft, edges ? 600 : 500);  // the veil is soft everywhere
        // Three roundings to a code, of at most 0.0044 near white. The edge filter sees other
        // brightness before grey than before nothing.
        if (!edges) {
            EXPECT_LE(worst, 0.012);
        } else {
            EXPECT_LE(far, 0.04 * 3 * r.width * r.height);
        }
    }
}

TEST_F(BackgroundTest, HighlightsOnClearGlassStay) {
    Scene s;
    Material pane = clearGlass();
    place(s, quad(4.0f, addMaterial(s, pane)));
    place(s, quad(4.0f, addMaterial(s, glowing({60, 60, 60}))), moved(0, 0, 4));
    FrameRequest r = request(s, "highlight on glass");
    r.output.format = OutputFormat::png;
    r.background = Background::transparent;
    const Image image = renderer().render(r).image;
    const std::uint8_t* p = image.bytes() + 4 * (32u * 64u + 32u);
    EXPECT_GT(p[3], 200) << "reflects 4 % of 60";
    EXPECT_GT(p[0], 200);
}

// One whose image circle contains the frame, at whose upper and lower edges it sees 0.8 rad.
void setFisheye(FrameRequest& r) {
    const double width = r.width, height = r.height, f = height / 1.6;
    r.camera.yfov.reset();
    r.camera.intrinsics = Intrinsics{f, f, width / 2.0, height / 2.0};
    r.camera.lens = FisheyeLens{};
}

// A lens is a sum of parts of several views; alpha is one of its numbers.
TEST_F(BackgroundTest, LensesKeepAlpha) {
    for (const LensRequest& lens :
         {LensRequest(FisheyeLens{}), LensRequest(PerspectiveLens{.k1 = -0.2})}) {
        FrameRequest r = stillLifeRequest(false, "still life through a lens");
        r.camera.position = glm::dvec3(0.0, 0.1, 1.6);
        r.camera.target = glm::dvec3(0.0, 0.0, 0.0);
        if (std::holds_alternative<FisheyeLens>(lens)) setFisheye(r);
        r.camera.lens = lens;
        r.background = Background::transparent;
        renderer().render(r);  // maps are resident from now on
        const Frame transparent = renderer().render(r);
        ASSERT_EQ(transparent.image.channels, 4u);
        ASSERT_TRUE(transparent.plan.lens);
        int covered = 0, open = 0;
        for (std::size_t i = 0; i < std::size_t{r.width} * r.height; ++i) {
            covered += transparent.image.floats()[4 * i + 3] > 0.999f;
            open += transparent.image.floats()[4 * i + 3] == 0.0f;
        }
        EXPECT_GT(covered, 500);
        EXPECT_GT(open, 5000);
        for (const Radiance& background : {kGrey, kSand}) {
            r.background = background;
            EXPECT_TRUE(imagesMatch(over(transparent.image, background), renderer().render(r).image,
                                    Tolerance{"sum in floats", 1e-5, 0.0}));
        }
    }
}

TEST_F(BackgroundTest, LensesKeepWhatGlassLetsThrough) {
    FrameRequest r = stillLifeRequest(true, "glass through a fisheye");
    setFisheye(r);
    r.background = Background::transparent;
    const Image transparent = renderer().render(r).image;
    r.background = Radiance{1.0, 1.0, 1.0};
    const Image white = renderer().render(r).image;
    r.background = Radiance{0.0, 0.0, 0.0};
    const Image black = renderer().render(r).image;
    double worst = 0.0;
    int partly = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const glm::vec3 through = color(white, x, y) - color(black, x, y);
            const float alpha = transparent.floats()[4 * (std::size_t{y} * r.width + x) + 3];
            worst =
                std::max(worst, std::abs(1.0 - alpha - (through.x + through.y + through.z) / 3.0));
            partly += alpha > 0.05f && alpha < 0.95f;
        }
    }
    EXPECT_LE(worst, 1e-5);
    EXPECT_GT(partly, 300);
}

// Filters treat alpha as they treat colour.
TEST_F(BackgroundTest, FiltersCommuteWithTheBackground) {
    FrameRequest r = stillLifeRequest(false, "filtered still life");
    ConvolveFilter blur;
    blur.kernel = KernelNumbers{1. / 16, 2. / 16, 1. / 16, 2. / 16, 4. / 16,
                                2. / 16, 1. / 16, 2. / 16, 1. / 16};
    r.filters = {TwirlFilter{.amount = 1.5}, blur};
    r.background = Background::transparent;
    const Image transparent = renderer().render(r).image;
    r.background = kSand;
    const Image direct = renderer().render(r).image;
    EXPECT_TRUE(
        imagesMatch(over(transparent, kSand), direct, Tolerance{"sum in floats", 1e-5, 0.0}));
}

TEST_F(BackgroundTest, MirrorsReflectTheMap) {
    Scene s;
    place(s, quad(4.0f, addMaterial(s, mirrorMetal())));
    for (const PlanarMethod method :
         {PlanarMethod::mirror, PlanarMethod::environment, PlanarMethod::traced}) {
        FrameRequest r = request(s, "mirror and colour");
        r.environment.map = "white";
        r.accuracy.planar = method;
        r.background = Radiance{0.0, 0.0, 5.0};
        const glm::vec3 seen = centerColor(renderer().render(r).image);
        EXPECT_NEAR(seen.x, 1.0, 0.02);
        EXPECT_NEAR(seen.z, 1.0, 0.02);
    }
}

TEST_F(BackgroundTest, TheMapIsTheDefault) {
    FrameRequest r = stillLifeRequest(true, "default background");
    const Frame without = renderer().render(r);
    r.background = Background::map;
    const Frame with = renderer().render(r);
    EXPECT_EQ(without.plan, with.plan);
    EXPECT_TRUE(imagesMatch(with.image, without.image, kExact));
}

}  // namespace
}  // namespace clerestory::test
