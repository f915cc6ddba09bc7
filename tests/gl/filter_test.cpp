// Twirl, convolution and glow compared with the same filters on the CPU, and their invariants.
#include "plan/request/filter_request.h"
#include "scene/builtin/builtin_scenes.h"
#include "support.h"
#include "tests/support/filter_truth.h"

#include <gmock/gmock.h>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Filters : public GlTest {};

// Twirls turn by a sine and a cosine in float32, whose error (some 1e-6; an angle of 100 radians
// has more) counts once a pixel of the radius, between neighbours as far apart as dark and lamp.
// Measured: 2e-5.
constexpr double kFloatError = 1e-4;

FilterRequest twirl(double amount, std::optional<double> radius = {}) {
    return TwirlFilter{.amount = amount, .radius = radius};
}
ConvolveFilter convolve(KernelName kernel, EdgeRule edge = EdgeRule::clamp) {
    return {.kernel = kernel, .edge = edge};
}
ConvolveFilter convolve(const KernelNumbers& kernel, EdgeRule edge = EdgeRule::clamp) {
    return {.kernel = kernel, .edge = edge};
}
FilterRequest glow(double threshold, double strength, double radius) {
    return GlowFilter{.radius = radius, .threshold = threshold, .strength = strength};
}

// Squares of four colours and a lamp under a sky: edges everywhere, light from 0 to 20.
FrameRequest colourful(std::uint32_t width, std::uint32_t height, std::uint32_t samples = 1) {
    Scene scene;
    Material squares = unlit({1, 1, 1, 1});
    squares.baseColorTexture.texture = addTexture2x2(
        scene, {glm::u8vec4(255, 30, 0, 255), {0, 255, 80, 255}, {10, 0, 255, 255}, {9, 9, 9, 255}},
        Wrap::repeat);
    place(scene, quad(1.3f, addMaterial(scene, squares)));
    place(scene, quad(0.15f, addMaterial(scene, glowing({20, 12, 3}))), moved(0.7, 0.55, 0.1));
    FrameRequest r = request(std::move(scene), "colourful");
    r.environment.map = "sky";
    r.width = width;
    r.height = height;
    r.accuracy.samples = samples;
    return r;
}

Picture drawn(FrameRequest r, std::vector<FilterRequest> filters = {}) {
    r.filters = std::move(filters);
    return Picture(renderer().render(r).image);
}

struct Size {
    std::uint32_t width, height, samples;
};
constexpr Size kSizes[] = {{64, 64, 1}, {97, 41, 1}, {40, 71, 4}, {1, 1, 1}, {1, 9, 4}, {7, 2, 1}};

std::string nameOf(const Size& size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height) + ", " +
           std::to_string(size.samples) + " samples";
}

// One lamp of 5 x 5 pixels, the middle of which lies at (x, y) of 129 x 97, in the dark.
constexpr std::uint32_t kWide = 129, kHigh = 97;
FrameRequest lampAt(int x, int y, const glm::vec3& radiance = glm::vec3(10.0f)) {
    Scene scene;
    const double pixel = 2.0 * 2.0 / kHigh;  // 90 degrees high, seen from a distance of 2
    place(scene, quad(static_cast<float>(2.5 * pixel), addMaterial(scene, glowing(radiance))),
          moved((x + 0.5 - 0.5 * kWide) * pixel, (0.5 * kHigh - y - 0.5) * pixel, 0.0));
    FrameRequest r = request(std::move(scene), "lamp");
    r.width = kWide;
    r.height = kHigh;
    return r;
}

struct Spot {
    glm::dvec2 middle;  // pixels from the upper left corner, centres at halves
    double variance;    // of x and y together
};
Spot spotOf(const Picture& picture) {
    double light = 0.0, square = 0.0;
    glm::dvec2 middle(0.0);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const glm::dvec2 at(x + 0.5, y + 0.5);
            const double here = picture.at(x, y).x;
            light += here;
            middle += here * at;
            square += here * glm::dot(at, at);
        }
    }
    middle /= light;
    return {middle, square / light - glm::dot(middle, middle)};
}

}  // namespace

TEST_F(Filters, TwirlMatchesTheCpu) {
    for (const Size& size : kSizes) {
        const FrameRequest r = colourful(size.width, size.height, size.samples);
        const Picture plain = drawn(r);
        for (const auto& [amount, radius] : std::initializer_list<std::pair<double, double>>{
                 {2.0, -1.0}, {-7.5, -1.0}, {3.0, 15.25}, {100.0, 20.0}}) {
            const auto limit = radius < 0.0 ? std::nullopt : std::optional(radius);
            EXPECT_LT(greatestDifference(drawn(r, {twirl(amount, limit)}),
                                         twirled(plain, amount, radius)),
                      kFloatError)
                << amount << " within " << radius << ", " << nameOf(size);
        }
    }
}

TEST_F(Filters, TwirlMovesPointsByTheFormula) {
    const glm::dvec2 middle(0.5 * kWide, 0.5 * kHigh);
    for (const auto& [x, y] : {std::pair(90, 48), std::pair(40, 20), std::pair(64, 70)}) {
        const FrameRequest r = lampAt(x, y);
        ASSERT_LT(glm::distance(spotOf(drawn(r)).middle, glm::dvec2(x + 0.5, y + 0.5)), 1e-3);
        const double amount = 1.5;
        // Clockwise on the screen, whose y points down: the angle grows.
        const glm::dvec2 arm = glm::dvec2(x + 0.5, y + 0.5) - middle;
        const double angle =
            std::atan2(arm.y, arm.x) + amount * glm::length(arm) / static_cast<double>(kHigh);
        const glm::dvec2 expected =
            middle + glm::length(arm) * glm::dvec2(std::cos(angle), std::sin(angle));
        EXPECT_LT(glm::distance(spotOf(drawn(r, {twirl(amount)})).middle, expected), 0.15)
            << x << " " << y;
    }
}

TEST_F(Filters, TwirlChangesNothingBeyondItsRadius) {
    const FrameRequest r = colourful(90, 60);
    const Picture plain = drawn(r), turned = drawn(r, {twirl(5.0, 20.0)});
    int changed = 0;
    for (int y = 0; y < plain.height; ++y) {
        for (int x = 0; x < plain.width; ++x) {
            const bool inside = std::hypot(x + 0.5 - 45.0, y + 0.5 - 30.0) <= 20.0;
            const bool same = plain.at(x, y) == turned.at(x, y);
            EXPECT_TRUE(inside || same) << x << " " << y;
            changed += !same;
        }
    }
    EXPECT_GT(changed, 500);
}

TEST_F(Filters, ConvolutionMatchesTheCpu) {
    const double n = 1.0 / 9.0, s = 1.0 / 16.0;
    const std::vector<std::pair<ConvolveFilter, KernelNumbers>> rows = {
        {convolve(KernelName::sharpen), {0, -1, 0, -1, 5, -1, 0, -1, 0}},
        {convolve(KernelName::box), {n, n, n, n, n, n, n, n, n}},
        {convolve(KernelName::gaussian), {s, 2 * s, s, 2 * s, 4 * s, 2 * s, s, 2 * s, s}},
        {convolve(KernelName::embossNorthWest), {-1, -1, 0, -1, 1, 1, 0, 1, 1}},
        {convolve(KernelName::embossNorthEast), {0, -1, -1, 1, 1, -1, 1, 1, 0}},
        {convolve(KernelName::embossSouthEast), {1, 1, 0, 1, 1, -1, 0, -1, -1}},
        {convolve(KernelName::embossSouthWest), {0, 1, 1, -1, 1, 1, -1, -1, 0}},
        {convolve({1, 2, 3, -4, 5, 6, 7, -8, 9.5}), {1, 2, 3, -4, 5, 6, 7, -8, 9.5}},
        {convolve({0, 0, 0, 0, 0, 1, 0, 0, 0}), {0, 0, 0, 0, 0, 1, 0, 0, 0}},
        {convolve({0, 1, 0, 0, 0, 0, 0, 0, 0}), {0, 1, 0, 0, 0, 0, 0, 0, 0}}};
    for (const Size& size : kSizes) {
        const FrameRequest r = colourful(size.width, size.height, size.samples);
        const Picture plain = drawn(r);
        for (const bool repeat : {false, true}) {
            for (std::size_t i = 0; i < rows.size(); ++i) {
                ConvolveFilter filter = rows[i].first;
                filter.edge = repeat ? EdgeRule::repeat : EdgeRule::clamp;
                EXPECT_LT(greatestDifference(drawn(r, {filter}),
                                             convolved(plain, rows[i].second, repeat)),
                          1e-5)
                    << "row " << i << (repeat ? " repeat " : " clamp ") << nameOf(size);
            }
        }
    }
}

TEST_F(Filters, NamedKernelsKeepUniformImages) {
    FrameRequest r = request(Scene{}, "nothing");
    r.environment.map = "grey";
    const Picture plain = drawn(r);
    for (const KernelName name :
         {KernelName::sharpen, KernelName::box, KernelName::gaussian, KernelName::embossNorthWest,
          KernelName::embossNorthEast, KernelName::embossSouthEast, KernelName::embossSouthWest}) {
        EXPECT_LT(greatestDifference(drawn(r, {convolve(name)}), plain), 1e-6);
    }
    r.environment.intensity = 50.0;
    EXPECT_LT(greatestDifference(drawn(r, {glow(1.0, 1.0, 64.0)}), drawn(r)), 1e-6);
}

TEST_F(Filters, GlowMatchesTheCpu) {
    for (const Size& size : kSizes) {
        const FrameRequest r = colourful(size.width, size.height, size.samples);
        const Picture plain = drawn(r);
        for (const auto& [threshold, strength, radius] :
             {std::tuple(1.0, 0.5, 32.0), std::tuple(0.0, 1.0, 1.5), std::tuple(3.0, 1.0, 5.0),
              std::tuple(0.2, 0.25, 8000.0)}) {
            EXPECT_LT(greatestDifference(drawn(r, {glow(threshold, strength, radius)}),
                                         glowing(plain, threshold, strength, radius)),
                      1e-5)
                << threshold << " " << strength << " " << radius << ", " << nameOf(size);
        }
    }
}

TEST_F(Filters, GlowConservesEnergyAndIsIsotropic) {
    const FrameRequest r = lampAt(64, 48);
    const Picture plain = drawn(r);
    double before = spotOf(plain).variance;
    for (const double radius : {1.5, 2.0, 3.0, 5.0, 8.0, 11.0, 16.0}) {
        const Picture spread = drawn(r, {glow(0.0, 1.0, radius)});
        EXPECT_NEAR(spread.sum().x / plain.sum().x, 1.0, 0.005) << radius;
        const Spot spot = spotOf(spread);
        EXPECT_LT(glm::distance(spot.middle, spotOf(plain).middle), 1.0) << radius;
        EXPECT_GT(spot.variance, before) << radius;
        EXPECT_LT(std::sqrt(spot.variance), 1.5 * radius + 2.0) << radius;
        before = spot.variance;
    }
}

TEST_F(Filters, GlowSurroundsEmissivePixelsOnly) {
    FrameRequest r = colourful(128, 96);
    r.environment.map = "grey";
    const Picture plain = drawn(r), glowed = drawn(r, {glow(1.5, 0.5, 8.0)});
    // Levels 1 to 3 of the pyramid; each spreads over three texels either way at most.
    const double reach = 3.0 * 8.0 * 1.42;
    double added = 0.0;
    for (int y = 0; y < plain.height; ++y) {
        for (int x = 0; x < plain.width; ++x) {
            double nearest = 1e9;
            for (int v = 0; v < plain.height; ++v) {
                for (int u = 0; u < plain.width; ++u) {
                    if (plain.at(u, v).x > 1.5) {
                        nearest = std::min(nearest, std::hypot(x - u, y - v));
                    }
                }
            }
            const bool emissive = plain.at(x, y).x > 1.5;
            if (nearest > reach) {
                EXPECT_EQ(plain.at(x, y), glowed.at(x, y)) << x << " " << y;
            } else if (!emissive) {
                EXPECT_GE(glowed.at(x, y).x, plain.at(x, y).x);
                added += glowed.at(x, y).x - plain.at(x, y).x;
            }
        }
    }
    EXPECT_GT(added, 10.0);
    r.effects.emission = false;
    EXPECT_EQ(drawn(r).pixels, drawn(r, {glow(1.5, 0.5, 8.0)}).pixels) << "nothing emits";
}

TEST_F(Filters, HiddenLampsDoNotGlow) {
    Scene scene;
    place(scene, quad(0.2f, addMaterial(scene, glowing({30, 30, 30}))), moved(0, 0, -0.5));
    place(scene, quad(0.5f, addMaterial(scene, unlit({0.5f, 0.5f, 0.5f, 1}))));
    FrameRequest r = request(std::move(scene), "hidden lamp");
    EXPECT_EQ(drawn(r).pixels, drawn(r, {glow(1.0, 1.0, 32.0)}).pixels);
}

TEST_F(Filters, GlowFollowsTheExposure) {
    FrameRequest r = colourful(64, 48);
    const Picture plain = drawn(r);
    r.exposure = 2.0;
    EXPECT_LT(greatestDifference(drawn(r, {glow(8.0, 0.5, 8.0)}), glowing(plain, 2.0, 0.5, 8.0)),
              1e-5);
}

TEST_F(Filters, RunInTheOrderOfTheRequest) {
    const FrameRequest r = colourful(75, 50);
    const Picture plain = drawn(r);
    const KernelNumbers emboss = numbersOf(KernelName::embossNorthWest);
    EXPECT_LT(greatestDifference(
                  drawn(r, {glow(1, 0.5, 8), twirl(3), convolve(KernelName::embossNorthWest)}),
                  convolved(twirled(glowing(plain, 1, 0.5, 8), 3), emboss, false)),
              10 * kFloatError);
    const Picture other = twirled(convolved(plain, emboss, false), 3);
    EXPECT_LT(
        greatestDifference(drawn(r, {convolve(KernelName::embossNorthWest), twirl(3)}), other),
        kFloatError);
    EXPECT_GT(
        greatestDifference(drawn(r, {twirl(3), convolve(KernelName::embossNorthWest)}), other),
        0.05);
    // The maximum number of filters: two targets alternate.
    Picture smooth = plain;
    std::vector<FilterRequest> many;
    while (many.size() < kMaxFilters) {
        many.push_back(convolve(KernelName::gaussian, EdgeRule::repeat));
        smooth = convolved(smooth, numbersOf(KernelName::gaussian), true);
    }
    EXPECT_LT(greatestDifference(drawn(r, many), smooth), 1e-5);
}

TEST_F(Filters, WithoutEffectChangeNoByte) {
    FrameRequest r = colourful(70, 40, 4);
    const std::vector<FilterRequest> nothing = {
        twirl(0.0), twirl(3.0, 0.0), convolve({0, 0, 0, 0, 1, 0, 0, 0, 0}, EdgeRule::repeat),
        glow(0.0, 0.0, 64.0), glow(0.0, 1.0, 1.0)};
    for (const OutputFormat format : {OutputFormat::npy, OutputFormat::png}) {
        r.output.format = format;
        r.filters.clear();
        const Frame plain = renderer().render(r);
        r.filters = nothing;
        const Frame filtered = renderer().render(r);
        EXPECT_EQ(plain.image.data, filtered.image.data);
        EXPECT_EQ(plain.plan.passes, filtered.plan.passes);
        EXPECT_EQ(filtered.plan.skipped.size(), plain.plan.skipped.size() + nothing.size());
        // Others do change it, and are forgotten with the next request.
        r.filters = {twirl(1.0), glow(1.0, 0.5, 16.0)};
        EXPECT_NE(plain.image.data, renderer().render(r).image.data);
        r.filters.clear();
        EXPECT_EQ(plain.image.data, renderer().render(r).image.data);
    }
}

TEST_F(Filters, DisplayedImagesAreFilteredThenToneMapped) {
    FrameRequest r = colourful(64, 64);
    r.filters = {glow(1, 0.5, 16), twirl(2), convolve(KernelName::sharpen)};
    const Image light = renderer().render(r).image;
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    const Image shown = renderer().render(r).image;
    std::size_t off = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            for (int c = 0; c < 3; ++c) {
                const double l = std::min(1.0f, color(light, x, y)[c]);
                const double code =
                    255.0 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
                const auto byte =
                    static_cast<int>(shown.data[(std::size_t{y} * 64 + x) * shown.channels + c]);
                off += std::abs(byte - code) > 1.0;
            }
        }
    }
    // Half floats before the kernel's differences: a few pixels next to the lamp.
    EXPECT_LE(off, 64u * 64u * 3u / 200);
}

TEST_F(Filters, DoNotApplyToDataChannels) {
    FrameRequest r = colourful(48, 32);
    for (const Channel channel :
         {Channel::depth, Channel::normal, Channel::objectId, Channel::through}) {
        r.output.channel = channel;
        r.filters.clear();
        const Image plain = renderer().render(r).image;
        r.filters = {twirl(3), convolve(KernelName::box), glow(0, 1, 16)};
        const Frame filtered = renderer().render(r);
        EXPECT_EQ(plain.data, filtered.image.data);
        EXPECT_EQ(filtered.plan.passes.size(), 1u);
        EXPECT_THAT(filtered.plan.skipped,
                    testing::Contains(testing::Field(
                        &Skipped::reason, "the request selects a data channel instead of colour")));
    }
}

TEST_F(Filters, StayFiniteAndNeverNegative) {
    FrameRequest r = lampAt(3, 3, glm::vec3(60000.0f));
    const KernelNumbers wild{1000, -1000, 1000, -1000, 1000, -1000, 1000, -1000, 1000};
    for (const OutputFormat format : {OutputFormat::npy, OutputFormat::png}) {
        r.output.format = format;
        r.filters = {convolve(wild), glow(0, 1, 8192), twirl(100), convolve(wild),
                     glow(65504, 1, 2)};
        for (const TargetHealth& target : renderer().render(r, Readback::health).health) {
            EXPECT_EQ(target.nonFinite, 0u) << target.target;
            EXPECT_EQ(target.negative, 0u) << target.target;
        }
    }
}

// A software driver leaves tone mapping and the edge filter to the processor. Both ways differ by
// rounding: of a tone-mapped code, and of codes between which the edge filter blends.
TEST(Display, TheProcessorGivesThePictureOfTheShaders) {
    Renderer shaders({.display = Computation::shader, .debugOutput = true});
    Renderer processor({.display = Computation::processor, .debugOutput = true});
    // Where the contrast is as large as the least one, only one may blend. A graphics card rounds
    // in its own way: where the direction of an edge differs, more may differ.
    const bool software = shaders.identity().software;
    const int bound = software ? 16 : 255;
    for (const char* id : {"teapots", "chapel"}) {
        for (Renderer* renderer : {&shaders, &processor}) {
            renderer->addScene(*makeBuiltinScene(id));
        }
        for (const ToneMap curve : {ToneMap::neutral, ToneMap::aces, ToneMap::linear}) {
            for (const bool edgeFilter : {false, true}) {
                FrameRequest r;
                r.effects.shadows = r.effects.indirectLight = false;
                r.scene = id;
                r.width = 325;  // odd, so that rows have a rest
                r.height = 181;
                r.toneMap = curve;
                r.exposure = 0.7;
                r.accuracy = accuracyOf(Preset::draft);
                r.accuracy.edgeFilter = edgeFilter;
                r.output.format = OutputFormat::png;
                const Frame a = shaders.render(r), b = processor.render(r);
                ASSERT_EQ(a.image.data.size(), b.image.data.size());
                EXPECT_EQ(a.plan.passes.size(), b.plan.passes.size());
                std::size_t sum = 0, far = 0;
                for (std::size_t i = 0; i < a.image.data.size(); ++i) {
                    const int difference = std::abs(a.image.bytes()[i] - b.image.bytes()[i]);
                    ASSERT_LE(difference, bound) << id << ' ' << i;
                    sum += static_cast<std::size_t>(difference);
                    far += difference > 1;
                }
                // A driver may be 0.6 codes off.
                EXPECT_LE(sum, a.image.data.size() / 5) << id;
                EXPECT_LE(far, a.image.data.size() / (software ? 1000 : 500)) << id;
            }
        }
        EXPECT_THAT(shaders.driverMessages(), testing::IsEmpty());
        EXPECT_THAT(processor.driverMessages(), testing::IsEmpty());
    }
}
