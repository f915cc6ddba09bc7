// Error measures: known pairs with known results. Expected values are closed forms, published
// colours, or a second, direct evaluation of the formula.
#include "measures/errors.h"
#include "scene/mesh_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace clerestory::test {
namespace {

using Color = glm::vec3;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Image painted(std::uint32_t width, std::uint32_t height,
              const std::function<Color(std::uint32_t, std::uint32_t)>& at,
              std::uint32_t channels = 3) {
    Image image = makeImage(width, height, channels, PixelType::float32);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const Color c = at(x, y);
            float* to = image.floats() + (std::size_t(y) * width + x) * channels;
            for (std::uint32_t k = 0; k < channels; ++k)
                to[k] = k < 3 ? c[int(k)] : 7.0f * float(x);
        }
    }
    return image;
}
Image uniform(Color color, std::uint32_t width = 16, std::uint32_t height = 12) {
    return painted(width, height, [&](auto, auto) { return color; });
}
// Any picture with structure.
Color pattern(std::uint32_t x, std::uint32_t y) {
    return Color(float((x * 37 + y * 11) % 29) / 28.0f, float((x * 5 + y * 23) % 17) / 16.0f,
                 float((x * 13 + y * 3) % 23) / 22.0f);
}
Mask maskOfColumns(std::uint32_t width, std::uint32_t height, std::uint32_t from,
                   std::uint32_t to) {
    Mask mask{width, height, std::vector<std::uint8_t>(std::size_t(width) * height)};
    for (std::size_t i = 0; i < mask.inside.size(); ++i) {
        mask.inside[i] = i % width >= from && i % width < to;
    }
    return mask;
}

}  // namespace

TEST(LinearErrors, AConstantOffsetIsTheBias) {
    const LinearErrors e = linearErrors(uniform(Color(0.6f)), uniform(Color(0.5f)));
    EXPECT_EQ(e.pixels, 16u * 12u);
    EXPECT_EQ(e.nonFinite, 0u);
    EXPECT_NEAR(e.meanReference, 0.5, 1e-7);
    EXPECT_NEAR(e.bias, 0.1, 1e-7);
    EXPECT_NEAR(e.rmse, 0.1, 1e-7);
    EXPECT_NEAR(e.p95, 0.1, 1e-7);
    EXPECT_NEAR(e.relMse, 0.01 / (0.25 + 0.005 * 0.005), 1e-7);
}

TEST(LinearErrors, AnImpulseChangesMeansNotThePercentile) {
    const auto impulse = [](std::uint32_t x, std::uint32_t y) {
        return Color(x == 3 && y == 4 ? 4.0f : 1.0f, 1.0f, 1.0f);
    };
    const LinearErrors e = linearErrors(painted(10, 10, impulse), uniform(Color(1.0f), 10, 10));
    EXPECT_NEAR(e.bias, 3.0 / 300.0, 1e-12);
    EXPECT_NEAR(e.rmse, std::sqrt(9.0 / 300.0), 1e-12);
    EXPECT_NEAR(e.relMse, 9.0 / 300.0 / (1.0 + 1e-4), 1e-12);
    EXPECT_NEAR(e.relMseTrimmed, e.relMse, 1e-12) << "a tenth of a pixel is none";
    EXPECT_EQ(e.p95, 0.0);
}

// Two glints of 2,000 pixels, which the trimmed measure leaves out; a third one counts.
TEST(LinearErrors, FewGlintsDoNotChangeTheTrimmedMeasure) {
    const auto error = [](std::uint32_t glints, double& trimmed) {
        const auto image = [glints](std::uint32_t x, std::uint32_t y) {
            return Color(y == 20 && x < glints ? 1000.0f : 1.1f);
        };
        const LinearErrors e = linearErrors(painted(50, 40, image), uniform(Color(1.0f), 50, 40));
        trimmed = e.relMseTrimmed;
        return e.relMse;
    };
    double none = 0.0, two = 0.0, three = 0.0;
    const double plain = error(0, none);
    EXPECT_NEAR(none, plain, 1e-12);
    EXPECT_NEAR(none, 0.01 / 1.0001, 1e-8);
    EXPECT_GT(error(2, two), 900.0);
    EXPECT_NEAR(two, none, 1e-12);
    EXPECT_GT(error(3, three), 1000.0);
    EXPECT_GT(three, 400.0);
}

TEST(LinearErrors, RelativeErrorIsIndependentOfBrightness) {
    double first = 0.0;
    for (const float scale : {1e-4f, 1.0f, 1e4f}) {
        const auto truth = [&](auto x, auto y) { return scale * (pattern(x, y) + 0.1f); };
        const auto twice = [&](auto x, auto y) { return 2.0f * truth(x, y); };
        const double relMse = linearErrors(painted(20, 9, twice), painted(20, 9, truth)).relMse;
        if (first == 0.0) first = relMse;
        EXPECT_NEAR(relMse, first, 1e-5) << scale;
        EXPECT_GT(relMse, 0.99);  // a little below 1 where the floor of 1 % is felt
        EXPECT_LT(relMse, 1.0);
    }
}

TEST(LinearErrors, ThePercentileIsTheLeastValueThat95PercentDoNotExceed) {
    const auto ramp = [](std::uint32_t x, auto) { return Color(float(x + 1)); };
    EXPECT_EQ(linearErrors(painted(100, 3, ramp), uniform(Color(0.0f), 100, 3)).p95, 95.0);
}

TEST(LinearErrors, EqualAndBlackImagesAreFinite) {
    const Image picture = painted(13, 7, pattern);
    const LinearErrors same = linearErrors(picture, picture);
    EXPECT_EQ(same.bias, 0.0);
    EXPECT_EQ(same.rmse, 0.0);
    EXPECT_EQ(same.relMse, 0.0);
    EXPECT_EQ(same.p95, 0.0);
    const Image black = uniform(Color(0.0f));
    EXPECT_EQ(linearErrors(black, black).relMse, 0.0);
    EXPECT_TRUE(std::isfinite(linearErrors(uniform(Color(65504.0f)), black).relMse));
}

TEST(LinearErrors, NonFinitePixelsAreReportedAndNotCounted) {
    const auto invalid = [](std::uint32_t x, std::uint32_t y) {
        if (y == 0 && x == 0) return Color(kNaN, 1.0f, 1.0f);
        if (y == 1 && x == 2) return Color(1.0f, kInf, -kInf);
        return Color(1.5f);
    };
    const LinearErrors e = linearErrors(painted(8, 8, invalid), uniform(Color(1.0f), 8, 8));
    EXPECT_EQ(e.nonFinite, 2u);
    EXPECT_EQ(e.pixels, 62u);
    EXPECT_NEAR(e.bias, 0.5, 1e-12);
    // In the reference as well, and nothing counts if every pixel is invalid.
    EXPECT_EQ(linearErrors(uniform(Color(1.0f), 8, 8), painted(8, 8, invalid)).nonFinite, 2u);
    const LinearErrors none = linearErrors(uniform(Color(kNaN)), uniform(Color(1.0f)));
    EXPECT_EQ(none.pixels, 0u);
    EXPECT_EQ(none.rmse, 0.0);
}

TEST(LinearErrors, OnlyMaskedPixelsCountAndAlphaIsIgnored) {
    const auto half = [](std::uint32_t x, auto) { return Color(x < 4 ? 1.0f : 3.0f); };
    const Mask mask = maskOfColumns(8, 4, 0, 4);
    EXPECT_EQ(mask.pixels(), 16u);
    const LinearErrors e = linearErrors(painted(8, 4, half, 4), uniform(Color(0.5f), 8, 4), &mask);
    EXPECT_EQ(e.pixels, 16u);
    EXPECT_NEAR(e.bias, 0.5, 1e-12);
    EXPECT_NEAR(e.rmse, 0.5, 1e-12);
}

TEST(LinearErrors, MismatchedImagesAreRejected) {
    const Image a = uniform(Color(1.0f), 4, 4);
    EXPECT_THROW(linearErrors(a, uniform(Color(1.0f), 4, 5)), std::runtime_error);
    EXPECT_THROW(linearErrors(a, makeImage(4, 4, 3, PixelType::srgb8)), std::runtime_error);
    EXPECT_THROW(linearErrors(a, makeImage(4, 4, 1, PixelType::float32)), std::runtime_error);
    const Mask mask = maskOfColumns(5, 4, 0, 5);
    EXPECT_THROW(linearErrors(a, a, &mask), std::runtime_error);
}

TEST(ClosedGap, RunsFromEffectOffToNoise) {
    EXPECT_DOUBLE_EQ(closedGap(0.1, 0.1, 0.001), 0.0);
    EXPECT_DOUBLE_EQ(closedGap(0.001, 0.1, 0.001), 1.0);
    EXPECT_DOUBLE_EQ(closedGap(0.0001, 0.1, 0.001), 1.0);  // below the noise is not better
    EXPECT_NEAR(closedGap(0.01, 0.1, 0.001), 0.5, 1e-12);  // half of the decades
    EXPECT_NEAR(closedGap(1.0, 0.1, 0.001), -0.5, 1e-12);
    EXPECT_DOUBLE_EQ(closedGap(0.1, 0.001, 0.001), 1.0);  // nothing to close
    for (const double error : {0.0, 1e-300, 1.0, 1e300}) {
        for (const double off : {0.0, 1e-300, 1.0, 1e300}) {
            for (const double floor : {0.0, 1e-300, 1.0, 1e300}) {
                EXPECT_TRUE(std::isfinite(closedGap(error, off, floor)));
            }
        }
    }
}

// ---- displayed pictures --------------------------------------------------------------------

TEST(DisplayedErrors, EqualImagesHaveTheMaximumDecibels) {
    const Image picture = painted(24, 20, pattern);
    for (const Image& p : {picture, quantised(picture)}) {
        const DisplayedErrors e = displayedErrors(p, p);
        EXPECT_EQ(e.pixels, 24u * 20u);
        EXPECT_EQ(e.psnr, kMaxDecibels);
        EXPECT_EQ(e.decibels, -kMaxDecibels);
        EXPECT_NEAR(e.ssim, 1.0, 1e-12);
        EXPECT_EQ(e.flip, 0.0);
    }
}

TEST(DisplayedErrors, OneCodeIs48Decibels) {
    Image a = makeImage(9, 9, 4, PixelType::srgb8), b = a;
    for (std::size_t i = 0; i < a.data.size(); ++i) {
        a.bytes()[i] = 100;
        b.bytes()[i] = i % 4 == 3 ? 3 : 101;  // alpha does not count
    }
    EXPECT_NEAR(psnr(a, b), 20.0 * std::log10(255.0), 1e-9);
    // Greys differ in y alone: d = 0.5053 * 1.
    EXPECT_NEAR(decibels(a, b), 10.0 * std::log10(0.5053 / 35215.0), 1e-4);
}

TEST(DisplayedErrors, DecibelsOfBlackAndWhiteAndOfOnePixel) {
    const double whole = 0.5053 * 255.0 * 255.0 / 35215.0;
    EXPECT_NEAR(decibels(uniform(Color(1.0f)), uniform(Color(0.0f))), 10.0 * std::log10(whole),
                1e-4);
    // The distance is squared already, and squared again for the root mean square: a pixel in 400
    // is 10 log10(1 / sqrt(400)) below all of them.
    const auto one = [](auto x, auto y) { return Color(x == 2 && y == 3 ? 1.0f : 0.0f); };
    EXPECT_NEAR(decibels(painted(20, 20, one), uniform(Color(0.0f), 20, 20)),
                10.0 * std::log10(whole / 20.0), 1e-4);
    // The greatest distance of two colours is 35215: that of red and cyan, 0 decibels.
    EXPECT_NEAR(decibels(uniform(Color(1.0f, 0.0f, 0.0f)), uniform(Color(0.0f, 1.0f, 1.0f))), 0.0,
                1e-4);
}

TEST(DisplayedErrors, NonFinitePixelsAreNotCounted) {
    const auto invalid = [](auto x, auto y) {
        return x == 8 && y == 6 ? Color(kNaN, kInf, 0.0f) : Color(0.5f);
    };
    const DisplayedErrors e = displayedErrors(painted(16, 12, invalid), uniform(Color(0.5f)));
    EXPECT_EQ(e.nonFinite, 1u);
    EXPECT_EQ(e.pixels, 16u * 12u - 1u);
    EXPECT_EQ(e.psnr, kMaxDecibels);
    EXPECT_EQ(e.flip, 0.0);
}

TEST(Ssim, UniformGreysGiveTheLuminanceTerm) {
    const double a = 0.25, b = 0.75, c1 = 1e-4;
    EXPECT_NEAR(ssim(uniform(Color(float(a))), uniform(Color(float(b)))),
                (2.0 * a * b + c1) / (a * a + b * b + c1), 1e-9);
}

TEST(Ssim, EqualsTheDirectSumOverEveryWindow) {
    const auto other = [](auto x, auto y) { return 0.7f * pattern(x + 1, y) + 0.1f; };
    const Image a = painted(17, 14, pattern), b = painted(17, 14, other);
    const auto luma = [](Color c) { return 0.299 * c.x + 0.587 * c.y + 0.114 * c.z; };
    double sum = 0.0;
    int windows = 0;
    for (int cy = 5; cy + 5 < 14; ++cy) {
        for (int cx = 5; cx + 5 < 17; ++cx, ++windows) {
            double weights = 0.0, ma = 0.0, mb = 0.0, va = 0.0, vb = 0.0, both = 0.0;
            const auto eachPixel = [&](auto&& visit) {
                for (int y = -5; y <= 5; ++y) {
                    for (int x = -5; x <= 5; ++x) {
                        const auto px = static_cast<std::uint32_t>(cx + x);
                        const auto py = static_cast<std::uint32_t>(cy + y);
                        visit(std::exp(-(x * x + y * y) / 4.5), luma(pattern(px, py)),
                              luma(other(px, py)));
                    }
                }
            };
            eachPixel([&](double w, double p, double q) {
                weights += w;
                ma += w * p;
                mb += w * q;
            });
            ma /= weights;
            mb /= weights;
            eachPixel([&](double w, double p, double q) {
                va += w / weights * (p - ma) * (p - ma);
                vb += w / weights * (q - mb) * (q - mb);
                both += w / weights * (p - ma) * (q - mb);
            });
            sum += (2 * ma * mb + 1e-4) * (2 * both + 9e-4) /
                   ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        }
    }
    EXPECT_NEAR(ssim(a, b), sum / windows, 1e-6);
    EXPECT_LT(ssim(a, b), 0.5);
}

// Of black and white, and of the two colours that the paper scales by, from their published CIELAB
// coordinates (sRGB, D65): green (87.735, -86.183, 83.179), blue (32.297, 79.188, -107.860).
TEST(Flip, UniformColoursGiveTheirMappedDistance) {
    const double greenA = 0.87735 * -86.183, greenB = 0.87735 * 83.179;
    const double blueA = 0.32297 * 79.188, blueB = 0.32297 * -107.860;
    const double greatest =
        std::pow(87.735 - 32.297 + std::hypot(greenA - blueA, greenB - blueB), 0.7);
    const double black = std::pow(100.0, 0.7);
    ASSERT_GT(black, 0.4 * greatest);
    const double expected = 0.95 + (black - 0.4 * greatest) / (0.6 * greatest) * 0.05;
    EXPECT_NEAR(flip(uniform(Color(0.0f)), uniform(Color(1.0f))), expected, 1e-4);
    EXPECT_NEAR(flip(uniform(Color(0.0f, 1.0f, 0.0f)), uniform(Color(0.0f, 0.0f, 1.0f))), 1.0,
                1e-4);
    // Two dark greys: below the knee. L of 0.02 linear is 116 cbrt(0.02) - 16, of 0.01 likewise.
    const auto code = [](double linear) {
        return float(1.055 * std::pow(linear, 1.0 / 2.4) - 0.055);
    };
    const double apart = 116.0 * (std::cbrt(0.02) - std::cbrt(0.01));
    EXPECT_NEAR(flip(uniform(Color(code(0.02))), uniform(Color(code(0.01)))),
                0.95 * std::pow(apart, 0.7) / (0.4 * greatest), 1e-4);
}

// A white image compared with one whose left half is black. Next to the edge the contrast
// sensitivity kernel covers `lit` of white, and the edge detector has all positive weights on one
// side.
TEST(Flip, EdgesRaiseTheColourDifference) {
    const auto halves = [](auto x, auto) { return Color(x < 40 ? 0.0f : 1.0f); };
    for (const double sharpness : {kPixelsPerDegree, 30.0}) {
        const double sigma = std::sqrt(0.0047 / 2.0) / std::acos(-1.0) * sharpness;
        double lit = 0.0, all = 0.0;
        for (int x = -60; x <= 60; ++x) {
            const double weight = std::exp(-0.5 * x * x / (sigma * sigma));
            all += weight;
            if (x >= 0) lit += weight;
        }
        const double apart = std::pow(116.0 - 116.0 * std::cbrt(lit / all), 0.7);
        const double greatest = std::pow(203.3, 0.7);  // of green and blue, to four digits
        const double colour = 0.95 * apart / (0.4 * greatest);
        const double expected = std::pow(colour, 1.0 - std::sqrt(1.0 / std::sqrt(2.0)));
        const Image map = flipMap(painted(80, 30, halves), uniform(Color(1.0f), 80, 30), sharpness);
        EXPECT_NEAR(map.floats()[15 * 80 + 40], expected, 2e-3) << sharpness;
        EXPECT_EQ(map.floats()[15 * 80 + 79], 0.0f);  // far from it
    }
}

TEST(Flip, ImpulsesAreVisibleFromNearAndBarelyFromAfar) {
    const auto impulse = [](auto x, auto y) { return Color(x == 30 && y == 20 ? 1.0f : 0.5f); };
    const Image a = painted(61, 41, impulse), grey = uniform(Color(0.5f), 61, 41);
    const Image map = flipMap(a, grey);
    float greatest = 0.0f;
    for (std::size_t i = 0; i < 61 * 41; ++i) {
        const float value = map.floats()[i];
        EXPECT_TRUE(value >= 0.0f && value <= 1.0f);
        if (value > greatest) greatest = value;
    }
    EXPECT_EQ(map.floats()[20 * 61 + 30], greatest);
    EXPECT_EQ(map.floats()[0], 0.0f);
    EXPECT_GT(flipMap(a, grey, 20.0).floats()[20 * 61 + 30],
              2.0f * flipMap(a, grey, 300.0).floats()[20 * 61 + 30]);
    // Neither of the two is favoured.
    EXPECT_EQ(flip(a, grey), flip(grey, a));
    const Mask corner = maskOfColumns(61, 41, 0, 10);
    EXPECT_EQ(flip(a, grey, &corner), 0.0);
}

// ---- masks, tone mapping, false colours ----------------------------------------------------

TEST(Masks, EachChannelValueMapsToItsEffect) {
    Image through = makeImage(8, 1, 1, PixelType::float32);
    const float numbers[] = {0, 1, 2, 3, 4, 16, 17, kNaN};
    std::copy_n(numbers, 8, through.floats());
    using Inside = std::vector<std::uint8_t>;
    EXPECT_EQ(maskOf(through, Effect::base).inside, (Inside{0, 1, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(maskOf(through, Effect::refraction).inside, (Inside{0, 0, 1, 0, 0, 0, 0, 0}));
    EXPECT_EQ(maskOf(through, Effect::environmentReflection).inside,
              (Inside{0, 0, 0, 1, 1, 0, 0, 0}));
    EXPECT_EQ(maskOf(through, Effect::planarReflection).inside, (Inside{0, 0, 0, 0, 0, 1, 1, 0}));
    EXPECT_EQ(maskOf(through, Effect::emission).pixels(), 0u);
    EXPECT_THROW(maskOf(uniform(Color(1.0f)), Effect::base), std::runtime_error);
}

TEST(Masks, EmissionMasksEmitters) {
    Scene scene;
    scene.materials.push_back({.name = "dull"});
    scene.materials.push_back({.name = "lamp", .emissive = glm::vec3(1.0f)});
    for (const Index material : {0u, 1u}) {
        MeshDraft draft{.name = "triangle", .material = material};
        draft.vertices.resize(3);
        draft.vertices[1].position = {1, 0, 0};
        draft.vertices[2].position = {0, 1, 0};
        draft.indices = {0, 1, 2};
        const Index mesh = addMesh(scene, std::move(draft));
        addInstance(scene, addNode(scene, "node", glm::dmat4(1.0)), mesh);
    }
    Image ids = makeImage(4, 1, 1, PixelType::float32);
    const float numbers[] = {0, 1, 2, 3};  // 3: no such instance
    std::copy_n(numbers, 4, ids.floats());
    EXPECT_EQ(emissionMask(ids, scene).inside, (std::vector<std::uint8_t>{0, 0, 1, 0}));
}

TEST(Displayed, CurvesEncodeAnyInput) {
    const auto hard = [](std::uint32_t x, auto) {
        const Color colors[] = {Color(0.5f), Color(kNaN, -1.0f, kInf), Color(1e30f), Color(0.0f)};
        return colors[x];
    };
    for (const ToneMap curve : {ToneMap::linear, ToneMap::neutral, ToneMap::aces}) {
        const Image shown = displayed(painted(4, 1, hard, 4), curve);
        EXPECT_EQ(shown.channels, 3u);
        for (std::size_t i = 0; i < 12; ++i) {
            EXPECT_TRUE(shown.floats()[i] >= 0.0f && shown.floats()[i] <= 1.0f);
        }
    }
    // IEC 61966-2-1 of 0.25 (0.5 one stop down) is 0.5370987, code 137.
    const Image linear = displayed(painted(4, 1, hard), ToneMap::linear, 0.5f);
    EXPECT_NEAR(linear.floats()[0], 0.5370987f, 1e-6f);
    EXPECT_EQ(quantised(linear).bytes()[0], 137);
    EXPECT_EQ(quantised(uniform(Color(kNaN, -1.0f, 2.0f), 1, 1)).bytes()[2], 255);
    EXPECT_THROW(displayed(makeImage(2, 2, 3, PixelType::srgb8), ToneMap::linear),
                 std::runtime_error);
}

TEST(ErrorPicture, BrightnessGrowsWithTheError) {
    double last = -1.0;
    for (int i = 0; i <= 100; ++i) {
        const glm::u8vec3 c = falseColour(i / 100.0);
        const double light = 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;  // codes, monotone enough
        EXPECT_GT(light, last) << i;
        last = light;
    }
    EXPECT_EQ(falseColour(kNaN), falseColour(0.0));
    EXPECT_EQ(falseColour(9.0), falseColour(1.0));

    const auto column = [](std::uint32_t x, auto) {
        const Color colors[] = {Color(1.0f), Color(2.0101f), Color(kNaN), Color(1.505f)};
        return colors[x];
    };
    // e is 1 % of 1, so an error of 1.01 is a relative one of 1.
    const Image picture = errorPicture(painted(4, 1, column), uniform(Color(1.0f), 4, 1));
    const auto color = [&](std::size_t x) {
        const std::uint8_t* p = picture.bytes() + 3 * x;
        return glm::u8vec3(p[0], p[1], p[2]);
    };
    EXPECT_EQ(color(0), falseColour(0.0));
    EXPECT_EQ(color(1), falseColour(1.0));
    EXPECT_EQ(color(2), glm::u8vec3(0, 255, 255));
    EXPECT_LE(glm::length(glm::vec3(color(3)) - glm::vec3(falseColour(0.5))), 1.5f);
}

}  // namespace clerestory::test
