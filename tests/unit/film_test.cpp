// Films, decoded again by libavcodec and libwebp and compared with their pictures.
#include "film/film.h"
#include "film/libav.h"
#include "measures/errors.h"
#include "tests/support/decoded_film.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <webp/decode.h>

#include <array>
#include <cmath>

namespace clerestory::test {
namespace {

constexpr std::uint32_t kWidth = 128, kHeight = 64, kPatch = 32;
using Color = std::array<std::uint8_t, 3>;
constexpr std::array<Color, 8> kColors{{{0, 0, 0},
                                        {255, 255, 255},
                                        {255, 0, 0},
                                        {0, 255, 0},
                                        {0, 0, 255},
                                        {128, 128, 128},
                                        {200, 120, 40},
                                        {30, 60, 90}}};

Image patches() {
    Image image = makeImage(kWidth, kHeight, 4, PixelType::srgb8);
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
        const std::uint32_t x = i % kWidth / kPatch, y = i / kWidth / kPatch;
        std::copy_n(kColors[y * 4 + x].data(), 3, image.bytes() + 4 * i);
        image.bytes()[4 * i + 3] = 255;
    }
    return image;
}

// Smooth waves of colour that move to the right by one pixel in each picture.
Image waves(std::uint32_t picture) {
    Image image = makeImage(kWidth, kHeight, 4, PixelType::srgb8);
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
        const double x = double(i % kWidth) - picture, y = i / kWidth;
        for (std::uint32_t c = 0; c < 3; ++c) {
            image.bytes()[4 * i + c] = static_cast<std::uint8_t>(
                std::lround(127.5 + 100.0 * std::sin(x * 0.1 + c) * std::cos(y * 0.07 * (c + 1))));
        }
        image.bytes()[4 * i + 3] = 255;
    }
    return image;
}

FilmSettings settings(FilmFormat format, double frameRate = 10.0) {
    return {.format = format, .width = kWidth, .height = kHeight, .frameRate = frameRate};
}

Bytes pictureFor(FilmFormat format, const Image& image) {
    return format == FilmFormat::mp4 ? encodePng(image) : encodeWebp(image, 85);
}

std::string filmOfWaves(const FilmSettings& settings, std::uint32_t count) {
    std::string bytes;
    const auto film = makeFilm(settings, [&](std::string_view piece) {
        bytes += piece;
        return true;
    });
    for (std::uint32_t i = 0; i < count; ++i) {
        EXPECT_TRUE(film->add(pictureFor(settings.format, waves(i))));
    }
    EXPECT_TRUE(film->end());
    return bytes;
}

TEST(Mp4Films, HaveThePicturesAtTheirTimes) {
    for (const double rate : {0.5, 10.0, 29.97, 60.0}) {
        SCOPED_TRACE(rate);
        const DecodedFilm film = decodedMp4(filmOfWaves(settings(FilmFormat::mp4, rate), 25));
        ASSERT_EQ(film.pictures.size(), 25u);
        EXPECT_NEAR(film.frameRate, rate, 1e-9);
        EXPECT_NEAR(film.seconds, 25 / rate, 1e-3);
        for (std::uint32_t i = 0; i < 25; ++i) {
            EXPECT_NEAR(film.times[i], i / rate, 1e-4);
            ASSERT_EQ(film.pictures[i].width, kWidth);
            ASSERT_EQ(film.pictures[i].height, kHeight);
            EXPECT_GT(psnr(film.pictures[i], waves(i)), 38.0) << i;
            EXPECT_LT(psnr(film.pictures[i], waves(i + 4)), 30.0) << "another picture";
        }
    }
}

TEST(Mp4Films, ColoursAreThoseOfThePictures) {
    std::string bytes;
    FilmSettings best = settings(FilmFormat::mp4);
    best.quality = 100;
    const auto film = makeFilm(best, [&](std::string_view piece) {
        bytes += piece;
        return true;
    });
    ASSERT_TRUE(film->add(encodePng(patches())) && film->end());
    const DecodedFilm decoded = decodedMp4(bytes);
    ASSERT_EQ(decoded.pictures.size(), 1u);
    EXPECT_TRUE(decoded.isTagged709);
    for (std::size_t patch = 0; patch < kColors.size(); ++patch) {
        // The inner half: colour at edges is blurred by its half resolution.
        std::array<double, 3> mean{};
        for (std::uint32_t i = 0; i < 16 * 16; ++i) {
            const std::size_t x = patch % 4 * kPatch + 8 + i % 16,
                              y = patch / 4 * kPatch + 8 + i / 16;
            for (std::size_t c = 0; c < 3; ++c) {
                mean[c] += decoded.pictures[0].bytes()[(y * kWidth + x) * 4 + c] / 256.0;
            }
        }
        // A step of limited range is 1.16 codes of luma, and up to 2.1 of a colour difference.
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(mean[c], kColors[patch][c], 2.0) << "patch " << patch << " colour " << c;
        }
    }
}

TEST(Mp4Films, BeginBeforeTheirLastPicture) {
    std::size_t sent = 0;
    const auto film = makeFilm(settings(FilmFormat::mp4), [&](std::string_view piece) {
        sent += piece.size();
        return true;
    });
    EXPECT_GT(sent, 0u) << "the head";
    const std::size_t head = sent;
    for (std::uint32_t i = 0; i < 11; ++i) ASSERT_TRUE(film->add(encodePng(waves(i))));
    EXPECT_GT(sent, head) << "a fragment for each second";
}

TEST(Films, AreTheSameBytesEachTime) {
    for (const FilmFormat format : {FilmFormat::mp4, FilmFormat::webp}) {
        EXPECT_EQ(filmOfWaves(settings(format), 25), filmOfWaves(settings(format), 25));
    }
}

TEST(Films, EndWithTheirClient) {
    for (const FilmFormat format : {FilmFormat::mp4, FilmFormat::webp}) {
        int calls = 0;
        {
            const auto film = makeFilm(settings(format), [&](std::string_view) {
                ++calls;
                return false;
            });
            bool more = true;
            for (std::uint32_t i = 0; more && i < 12; ++i) {
                more = film->add(pictureFor(format, waves(i)));
            }
            EXPECT_FALSE(more && film->end());
        }
        EXPECT_EQ(calls, 1) << "nothing is sent after the disconnect";
    }
}

TEST(Films, OtherPicturesAreRefused) {
    for (const FilmFormat format : {FilmFormat::mp4, FilmFormat::webp}) {
        const auto film = makeFilm(settings(format), [](std::string_view) { return true; });
        EXPECT_THROW(film->add("no picture"), std::runtime_error);
    }
    const auto film = makeFilm(settings(FilmFormat::mp4), [](std::string_view) { return true; });
    EXPECT_THROW(film->add(encodePng(makeImage(64, 64, 4, PixelType::srgb8))), std::runtime_error);
}

TEST(Mp4Films, AMissingLibraryIsNamed) {
    EXPECT_EQ(mp4Missing(), "");
    try {
        loadLibav("libavformat.so.1");
        ADD_FAILURE();
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("libavformat.so.1"));
    }
}

// The pictures are put together without another loss.
TEST(WebpFilms, HaveThePicturesAtTheirTimes) {
    for (const double rate : {10.0, 29.97}) {
        const DecodedFilm film = decodedWebp(filmOfWaves(settings(FilmFormat::webp, rate), 25));
        ASSERT_EQ(film.pictures.size(), 25u);
        EXPECT_NEAR(film.seconds, 25 / rate, 0.0005);
        for (std::uint32_t i = 0; i < 25; ++i) {
            EXPECT_NEAR(film.times[i], i / rate, 0.0005 + 1e-9);
            const Bytes single = encodeWebp(waves(i), 85);
            Image image = makeImage(kWidth, kHeight, 4, PixelType::srgb8);
            ASSERT_TRUE(WebPDecodeRGBAInto(reinterpret_cast<const std::uint8_t*>(single.data()),
                                           single.size(), image.bytes(), image.data.size(),
                                           4 * kWidth));
            EXPECT_EQ(film.pictures[i].data, image.data) << i;
        }
    }
}

}  // namespace
}  // namespace clerestory::test
