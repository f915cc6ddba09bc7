// Image comparison: known pairs with known results.
#include "tests/support/compare_images.h"

#include "image/image.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace clerestory::test {
namespace {

Image grey(std::uint32_t width, std::uint32_t height, std::uint8_t value) {
    Image image = makeImage(width, height, 3, PixelType::srgb8);
    std::fill_n(image.bytes(), image.data.size(), value);
    return image;
}

Image floats(std::uint32_t width, std::uint32_t height, float value) {
    Image image = makeImage(width, height, 1, PixelType::float32);
    std::fill_n(image.floats(), std::size_t(width) * height, value);
    return image;
}

TEST(ImageCompare, EqualImagesDifferByNothing) {
    const Difference d = difference(grey(4, 3, 100), grey(4, 3, 100), 0.0);
    EXPECT_TRUE(d.sameShape);
    EXPECT_EQ(d.max, 0.0);
    EXPECT_EQ(d.mean, 0.0);
    EXPECT_EQ(d.shareOver, 0.0);
    EXPECT_TRUE(imagesMatch(grey(4, 3, 100), grey(4, 3, 100), kExact));
}

TEST(ImageCompare, OneChangedSampleIsLocated) {
    Image changed = grey(10, 5, 100);
    changed.bytes()[(3 * 10 + 7) * 3 + 1] = 151;  // row 3, column 7, green: 51 of 255 more
    const Difference d = difference(changed, grey(10, 5, 100), 0.1);
    EXPECT_DOUBLE_EQ(d.max, 0.2);
    EXPECT_DOUBLE_EQ(d.mean, 0.2 / 150.0);
    EXPECT_DOUBLE_EQ(d.shareOver, 1.0 / 50.0);
    EXPECT_EQ(d.worstX, 7u);
    EXPECT_EQ(d.worstY, 3u);
}

TEST(ImageCompare, RoundingAllowsOneCodeEverywhereAndNotTwo) {
    for (int code = 1; code < 256; ++code) {
        const auto next = static_cast<std::uint8_t>(code),
                   one = static_cast<std::uint8_t>(code - 1);
        EXPECT_TRUE(imagesMatch(grey(4, 4, next), grey(4, 4, one), kRounding)) << code;
    }
    EXPECT_FALSE(imagesMatch(grey(4, 4, 101), grey(4, 4, 100), kExact));
    Image changed = grey(4, 4, 100);
    changed.bytes()[0] = 102;
    EXPECT_FALSE(imagesMatch(changed, grey(4, 4, 100), kRounding));
}

TEST(ImageCompare, EdgesAllowOnePixelInAThousandBeyondFiveCodes) {
    Image changed = grey(50, 40, 105);  // 2000 pixels
    EXPECT_TRUE(imagesMatch(changed, grey(50, 40, 100), kEdges));
    changed.bytes()[0] = 255;
    changed.bytes()[3] = 255;
    EXPECT_TRUE(imagesMatch(changed, grey(50, 40, 100), kEdges));
    changed.bytes()[6] = 255;
    EXPECT_FALSE(imagesMatch(changed, grey(50, 40, 100), kEdges));
}

TEST(ImageCompare, NonFiniteSamplesAlwaysFail) {
    const Tolerance anything{"anything", 1e30, 1.0};
    EXPECT_TRUE(imagesMatch(floats(2, 2, 0.0f), floats(2, 2, 9.0f), anything));
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        Image broken = floats(2, 2, 1.0f);
        broken.floats()[2] = bad;
        EXPECT_FALSE(imagesMatch(broken, floats(2, 2, 1.0f), anything));
        EXPECT_FALSE(imagesMatch(floats(2, 2, 1.0f), broken, anything));
        EXPECT_FALSE(imagesMatch(broken, broken, anything)) << "equal faults are listed separately";
        const Difference d = difference(broken, floats(2, 2, 1.0f), 0.0);
        EXPECT_EQ(d.nonFinite, 1u);
        EXPECT_EQ(d.worstX, 0u);
        EXPECT_EQ(d.worstY, 1u);
    }
}

TEST(ImageCompare, DifferentShapesNeverMatch) {
    const Tolerance anything{"anything", 1e30, 1.0};
    EXPECT_FALSE(imagesMatch(grey(4, 3, 0), grey(3, 4, 0), anything));
    EXPECT_FALSE(imagesMatch(grey(4, 3, 0), makeImage(4, 3, 4, PixelType::srgb8), anything));
    EXPECT_FALSE(imagesMatch(makeImage(4, 3, 3, PixelType::float32), grey(4, 3, 0), anything));
}

TEST(ImageCompare, AFailureWritesBothImages) {
    const auto path =
        std::filesystem::path(CLERESTORY_TEST_OUTPUT) / "ImageCompare.AFailureWritesBothImages.png";
    std::filesystem::remove(path);
    Image changed = grey(2, 1, 10);
    changed.bytes()[3] = 210;  // the second pixel's red
    EXPECT_FALSE(imagesMatch(changed, grey(2, 1, 10), kRounding));
    std::ifstream file(path, std::ios::binary);
    const Image picture = decodePng(std::string(std::istreambuf_iterator<char>(file), {}));
    ASSERT_EQ(picture.width, 6u);
    ASSERT_EQ(picture.height, 1u);
    EXPECT_EQ(picture.bytes()[1 * 4], 210);  // actual
    EXPECT_EQ(picture.bytes()[3 * 4], 10);   // expected
    EXPECT_EQ(picture.bytes()[4 * 4], 0);    // difference: none here,
    EXPECT_EQ(picture.bytes()[5 * 4], 255);  // the greatest there
}

}  // namespace
}  // namespace clerestory::test
