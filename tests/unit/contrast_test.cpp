// The pixels of a picture that have contrast.
#include "display/contrast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace clerestory::test {
namespace {

using display::contrastingPixels;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint32_t kWidth = 20, kHeight = 12;

Image grey(std::uint8_t code) {
    Image image = makeImage(kWidth, kHeight, 4, PixelType::srgb8);
    std::fill_n(image.bytes(), image.data.size(), code);
    return image;
}

void set(Image& image, std::uint32_t x, std::uint32_t y, std::uint32_t channel, std::uint8_t code) {
    image.bytes()[4 * (y * kWidth + x) + channel] = code;
}

TEST(Contrast, AnEvenPictureHasNone) {
    EXPECT_THAT(contrastingPixels(grey(100), {.leastContrast = 0.01}), IsEmpty());
    EXPECT_THAT(contrastingPixels(grey(100), {.leastContrast = 0.0}), SizeIs(kWidth * kHeight));
}

TEST(Contrast, IsThatOfAnyChannelWithTheEightNeighbours) {
    for (std::uint32_t channel = 0; channel < 4; ++channel) {
        Image image = grey(100);
        set(image, 5, 0, channel, 151);  // 0.2 of 255
        EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.2}),
                    ElementsAre(4, 5, 6, kWidth + 4, kWidth + 5, kWidth + 6));
        EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.21}), IsEmpty());
    }
}

TEST(Contrast, TheMostContrastComesFirst) {
    Image image = grey(0);
    set(image, 4, 4, 0, 60);
    set(image, 14, 4, 0, 90);
    EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.1}), SizeIs(18));
    const auto nine = contrastingPixels(image, {.leastContrast = 0.1, .share = 0.0375});
    ASSERT_THAT(nine, SizeIs(9));
    for (const std::uint32_t pixel : nine) EXPECT_GE(pixel % kWidth, 13u);
    // Nine have equal contrast, and two are allowed: not the first two.
    const auto two = contrastingPixels(image, {.leastContrast = 0.1, .share = 0.01});
    ASSERT_THAT(two, SizeIs(2));
    EXPECT_GT(two[1], two[0] + kWidth / 2);
}

TEST(Contrast, NearLampsThereMayBeMore) {
    Image image = grey(0);
    set(image, 10, 6, 1, 255);
    const auto pixels = contrastingPixels(image, {.leastContrast = 0.4});
    EXPECT_THAT(pixels, SizeIs(9 * 9));
    EXPECT_EQ(pixels.front(), 2 * kWidth + 6);
    EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.5}), SizeIs(9));
}

TEST(Contrast, PicturesOfOnePixelOrRow) {
    Image image = makeImage(1, 1, 4, PixelType::srgb8);
    EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.1}), IsEmpty());
    image = makeImage(3, 1, 4, PixelType::srgb8);
    std::fill_n(image.bytes(), 12, 0);
    image.bytes()[8] = 255;
    EXPECT_THAT(contrastingPixels(image, {.leastContrast = 0.5}), ElementsAre(1, 2));
}

}  // namespace
}  // namespace clerestory::test
