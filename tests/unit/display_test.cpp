// The display colours of the processor: tone curves against the shaders' formulae, sRGB against its
// definition, and an edge filter that changes edges only.
#include "display/display.h"
#include "display/srgb_code.h"
#include "image/bands.h"
#include "optics_support.h"
#include "plan/graph/supersampling.h"

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include <array>
#include <atomic>
#include <cmath>
#include <random>
#include <span>

namespace clerestory::test {
namespace {

using display::Picture;

std::vector<std::uint64_t> anyHalves(std::size_t count, bool finite) {
    std::mt19937_64 random(7);
    std::vector<std::uint64_t> halves(count);
    for (std::uint64_t& h : halves) {
        h = random();
        if (finite) h &= 0x3fff'3fff'3fff'3fffull;  // 0..2
    }
    return halves;
}

std::uint64_t halves(const glm::vec3& radiance) {
    return glm::packHalf4x16(glm::vec4(radiance, 1.0f));
}

Picture mapped(std::uint32_t width, std::uint32_t height, std::span<const std::uint64_t> pixels,
               ToneMap curve = ToneMap::linear, float exposureFactor = 1.0f) {
    Picture picture;
    display::toneMap({width, height, pixels}, curve, exposureFactor, true, picture);
    return picture;
}

glm::vec3 expected(std::uint64_t pixel, ToneMap curve, float exposureFactor) {
    const glm::vec3 radiance = exposureFactor * glm::vec3(glm::unpackHalf4x16(pixel));
    switch (curve) {
        case ToneMap::neutral:
            return glsl::toneMapNeutral(radiance);
        case ToneMap::aces:
            return glsl::toneMapAces(radiance);
        case ToneMap::linear:
            break;
    }
    return glsl::toneMapLinear(radiance);
}

TEST(Display, CurvesAreThoseOfTheShaders) {
    constexpr std::uint32_t kWidth = 251, kHeight = 128;  // rows with a rest of three pixels
    for (const ToneMap curve : {ToneMap::neutral, ToneMap::aces, ToneMap::linear}) {
        for (const bool finite : {true, false}) {
            const std::vector<std::uint64_t> pixels = anyHalves(kWidth * kHeight, finite);
            const Picture picture = mapped(kWidth, kHeight, pixels, curve, 1.3f);
            std::size_t different = 0;
            for (std::uint32_t y = 0; y < kHeight; ++y) {
                for (std::uint32_t x = 0; x < kWidth; ++x) {
                    const glm::vec3 light =
                        expected(pixels[(kHeight - 1 - y) * kWidth + x], curve, 1.3f);
                    const glm::vec3 code = 255.0f * glsl::srgbFromLinear(light);
                    const std::size_t at = y * kWidth + x;
                    const std::uint8_t* actual = picture.image.bytes() + 4 * at;
                    for (int c = 0; c < 3; ++c) {
                        ASSERT_NEAR(actual[c], code[c], 0.501f) << x << ' ' << y << ' ' << c;
                        different += actual[c] != std::lround(code[c]);
                    }
                    ASSERT_EQ(actual[3], 255);
                    ASSERT_NEAR(picture.brightness[at], 255.0f * std::sqrt(glsl::luminance(light)),
                                0.51f);
                }
            }
            EXPECT_LE(different, kWidth * kHeight / 1000u);
        }
    }
}

TEST(Display, CodesAreTheNearestOnes) {
    const display::SrgbCodes& codes = display::srgbCodes();
    for (int code = 0; code < 256; ++code) {
        EXPECT_EQ(codes.code(codes.light(static_cast<std::uint8_t>(code))), code);
        EXPECT_NEAR(codes.light(static_cast<std::uint8_t>(code)),
                    glsl::linearFromSrgb(static_cast<float>(code) / 255.0f), 1e-6f);
    }
    for (int i = 0; i <= 1'000'000; ++i) {
        const float light = static_cast<float>(i) * 1e-6f;
        ASSERT_NEAR(codes.code(light), 255.0f * glsl::srgbFromLinear(light), 0.5002f) << light;
    }
}

// A white half plane behind an edge of this slope.
std::vector<std::uint64_t> halfPlane(std::uint32_t edge, float slope) {
    std::vector<std::uint64_t> pixels(std::size_t{edge} * edge);
    for (std::uint32_t y = 0; y < edge; ++y) {
        for (std::uint32_t x = 0; x < edge; ++x) {
            const bool white = static_cast<float>(y) > 20.3f + slope * static_cast<float>(x);
            pixels[y * edge + x] = halves(glm::vec3(white ? 1.0f : 0.0f));
        }
    }
    return pixels;
}

TEST(Display, EdgesAreSmoothedAndNothingElse) {
    constexpr std::uint32_t kEdge = 100;
    for (const float slope : {0.0f, 0.3f, 1.0f, -0.1f}) {
        const Picture picture = mapped(kEdge, kEdge, halfPlane(kEdge, slope));
        Image smoothed;
        display::smoothEdges(picture, false, smoothed);
        const auto at = [](const Image& image, std::uint32_t x, std::uint32_t y) {
            return int{image.bytes()[4 * (y * kEdge + x)]};
        };
        std::size_t between = 0;
        for (std::uint32_t y = 1; y + 1 < kEdge; ++y) {
            for (std::uint32_t x = 1; x + 1 < kEdge; ++x) {
                bool edge = false;
                for (std::uint32_t n = 0; n < 9; ++n) {
                    edge |=
                        at(picture.image, x - 1 + n % 3, y - 1 + n / 3) != at(picture.image, x, y);
                }
                const int value = at(smoothed, x, y);
                ASSERT_TRUE(edge || value == at(picture.image, x, y)) << x << ' ' << y;
                between += value > 0 && value < 255;
                ASSERT_EQ(smoothed.bytes()[4 * (y * kEdge + x) + 3], 255);
            }
        }
        EXPECT_GT(between, 60u) << slope;
    }
}

// The edge of a lamp 1000 times as bright as the wall lies anywhere between two rows. A row of
// which the lamp covers a little is white.
TEST(Display, EdgesOfLampsAreNearTheirCoverage) {
    constexpr std::uint32_t kEdge = 16, kOffsets = 64;
    const glm::vec3 wall(0.1f), lamp(100.0f);
    double plain = 0.0, aware = 0.0;
    for (std::uint32_t i = 0; i < kOffsets; ++i) {
        const float edge = 8.0f + (static_cast<float>(i) + 0.5f) / kOffsets;
        std::vector<std::uint64_t> point, exact;
        for (std::uint32_t y = 0; y < kEdge; ++y) {
            const float row = static_cast<float>(y);
            const float covered = std::clamp(row + 1.0f - edge, 0.0f, 1.0f);
            for (std::uint32_t x = 0; x < kEdge; ++x) {
                point.push_back(halves(row + 0.5f > edge ? lamp : wall));
                exact.push_back(halves(glm::mix(wall, lamp, covered)));
            }
        }
        const Picture truth = mapped(kEdge, kEdge, exact, ToneMap::neutral);
        Picture picture = mapped(kEdge, kEdge, point, ToneMap::neutral);
        for (const bool compressed : {true, false}) {
            picture.compressed = compressed;
            Image smoothed;
            display::smoothEdges(picture, false, smoothed);
            for (std::uint32_t y = 0; y < kEdge; ++y) {
                const std::size_t at = 4 * (y * kEdge + 8);
                const double d = double(smoothed.bytes()[at]) - truth.image.bytes()[at];
                (compressed ? aware : plain) += d * d * d * d;  // as the published decibels
            }
        }
    }
    EXPECT_LT(std::pow(aware, 0.25), 0.9 * std::pow(plain, 0.25));
}

// Sums of squared differences of pictures of edges of all directions, of which each pixel has the
// mean of these samples: not smoothed from exact, smoothed from exact, and smoothed from not
// smoothed. several: the filter knows of several samples.
std::array<double, 3> differencesOfEdges(std::span<const glm::vec2> samples, bool several) {
    constexpr std::uint32_t kEdge = 24;
    std::array<double, 3> sums{};
    for (int turn = 0; turn < 48; ++turn) {
        const float angle = 0.1309f * (static_cast<float>(turn) + 0.37f);
        const auto light = [&](const glm::vec2& p) {
            const glm::vec2 q = p - 12.0f - 0.31f * static_cast<float>(turn % 7);
            return q.x * std::cos(angle) + q.y * std::sin(angle) > 0.0f ? 1.0f : 0.05f;
        };
        std::vector<std::uint64_t> sampled, exact;
        for (std::uint32_t i = 0; i < kEdge * kEdge; ++i) {
            const glm::vec2 corner(static_cast<float>(i % kEdge), static_cast<float>(i / kEdge));
            float few = 0.0f, many = 0.0f;
            for (const glm::vec2& s : samples) few += light(corner + s);
            for (std::uint32_t k = 0; k < 256; ++k) {
                const glm::vec2 cell(static_cast<float>(k % 16), static_cast<float>(k / 16));
                many += light(corner + (cell + 0.5f) / 16.0f);
            }
            sampled.push_back(halves(glm::vec3(few / static_cast<float>(samples.size()))));
            exact.push_back(halves(glm::vec3(many / 256.0f)));
        }
        const Picture truth = mapped(kEdge, kEdge, exact), picture = mapped(kEdge, kEdge, sampled);
        Image smoothed;
        display::smoothEdges(picture, several, smoothed);
        for (std::size_t i = 0; i < 4 * kEdge * kEdge; ++i) {
            const int pixel = picture.image.bytes()[i], exactly = truth.image.bytes()[i],
                      result = smoothed.bytes()[i];
            sums[0] += std::pow(pixel - exactly, 2);
            sums[1] += std::pow(result - exactly, 2);
            sums[2] += std::pow(result - pixel, 2);
        }
    }
    return sums;
}

// Pixels with six samples need little of the filter; those that have one, because others have more
// contrast, need it.
TEST(Display, WhatSamplesHaveSmoothedChangesLittle) {
    std::vector<glm::vec2> six;
    for (std::uint32_t i = 0; i < 6; ++i) six.emplace_back(samplePlace(i) + 0.5);
    constexpr glm::vec2 kOne[] = {{0.5f, 0.5f}};
    const auto ofSix = differencesOfEdges(six, true), ofOne = differencesOfEdges(kOne, true),
               asOfOne = differencesOfEdges(six, false);
    EXPECT_LT(ofSix[1], ofSix[0]);
    EXPECT_LT(ofSix[1], asOfOne[1]);
    EXPECT_LT(ofOne[1], 0.7 * ofOne[0]);
}

// What is three pixels wide, such as a highlight, is not aliased.
TEST(Display, WideTransitionsChangeLittle) {
    std::vector<glm::vec2> wide;
    for (int y = -12; y < 24; ++y) {
        for (int x = -12; x < 24; ++x) wide.push_back((glm::vec2(x, y) + 0.5f) / 12.0f);
    }
    constexpr glm::vec2 kNarrow[] = {{0.5f, 0.5f}};
    EXPECT_LT(differencesOfEdges(wide, false)[2], 0.05 * differencesOfEdges(kNarrow, false)[2]);
}

TEST(Display, LightBeforeTheCurveIsTheInverseOfDisplayLight) {
    constexpr std::uint8_t kFirstCompressed = 226;
    const display::SrgbCodes& codes = display::srgbCodes();
    for (int code = 0; code < 256; ++code) {
        const auto c = static_cast<std::uint8_t>(code);
        EXPECT_NEAR(display::compressed(codes.uncompressed(c)), codes.light(c), 1e-5f);
        if (c < kFirstCompressed) {
            EXPECT_NEAR(codes.uncompressed(c), codes.light(c), 1e-6f);
        } else {
            EXPECT_GT(codes.uncompressed(c), codes.light(c) - 1e-5f);
        }
    }
    EXPECT_GT(codes.uncompressed(255), 30.0f);
}

TEST(Display, PicturesOfAnySizeHaveTheSamePixels) {
    // The left part of a picture is the picture of the left part, except for its border.
    constexpr std::uint32_t kHeight = 9, kMaxWidth = 80;
    const std::vector<std::uint64_t> pixels = anyHalves(kMaxWidth * kHeight, true);
    Image whole;
    display::smoothEdges(mapped(kMaxWidth, kHeight, pixels), false, whole);
    for (std::uint32_t width = 1; width < kMaxWidth; ++width) {
        std::vector<std::uint64_t> part;
        for (std::uint32_t y = 0; y < kHeight; ++y) {
            part.insert(part.end(), pixels.begin() + y * kMaxWidth,
                        pixels.begin() + y * kMaxWidth + width);
        }
        Image smoothed;
        display::smoothEdges(mapped(width, kHeight, part), false, smoothed);
        for (std::uint32_t y = 0; y < kHeight; ++y) {
            for (std::uint32_t x = 0; x + 1 < width; ++x) {
                for (std::uint32_t c = 0; c < 4; ++c) {
                    ASSERT_EQ(smoothed.bytes()[4 * (y * width + x) + c],
                              whole.bytes()[4 * (y * kMaxWidth + x) + c])
                        << width << ": " << x << ' ' << y;
                }
            }
        }
    }
}

TEST(Display, OneThreadGivesTheBytesOfSeveral) {
    const std::vector<std::uint64_t> pixels = anyHalves(200 * 150, true);
    Image images[2];
    for (const std::uint32_t threads : {1u, 4u}) {
        limitBandThreads(threads);
        const Picture picture = mapped(200, 150, pixels, ToneMap::neutral);
        display::smoothEdges(picture, false, images[threads > 1]);
    }
    limitBandThreads(0);
    EXPECT_EQ(images[0].data, images[1].data);
}

TEST(Bands, CoverEachRowOnce) {
    for (const std::uint32_t rows : {0u, 1u, 7u, 8u, 9u, 100u}) {
        std::vector<std::atomic<int>> visits(rows);
        forEachBand(rows, 8, [&](std::uint32_t first, std::uint32_t end) {
            ASSERT_LE(end - first, 8u);
            for (; first < end; ++first) ++visits[first];
        });
        for (const auto& count : visits) EXPECT_EQ(count, 1);
    }
}

}  // namespace
}  // namespace clerestory::test
