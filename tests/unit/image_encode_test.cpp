// Output of the encoders, read by other decoders where available, or compared byte by byte with the
// formats' specifications.
#include "image/image.h"
#include "tests/support/compare_images.h"

#include <gtest/gtest.h>
#include <tinyexr.h>
#include <webp/decode.h>

#include <array>
#include <cmath>
#include <cstring>
#include <future>
#include <limits>
#include <memory>
#include <stdexcept>

namespace clerestory::test {
namespace {

// Smooth in all channels, different in each corner.
Image gradient(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
    Image image = makeImage(width, height, channels, PixelType::srgb8);
    std::uint8_t* to = image.bytes();
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::array<std::uint32_t, 4> pixel{255 * x / width, 255 * y / height,
                                                     255 - 255 * x / width, 255 - 100 * y / height};
            for (std::uint32_t c = 0; c < channels; ++c)
                *to++ = static_cast<std::uint8_t>(pixel[c]);
        }
    }
    return image;
}

Image hardFloats(std::uint32_t channels) {
    Image image = makeImage(3, 2, channels, PixelType::float32);
    const std::array<float, 6> values{0.0f,     1e-30f, 65504.0f,
                                      -12.375f, 3e38f,  std::numeric_limits<float>::infinity()};
    for (std::uint32_t i = 0; i < 6 * channels; ++i) {
        image.floats()[i] = values[i % 6] + float(i / 6);
    }
    return image;
}

Image withoutAlpha(const Image& image) {
    Image rgb = makeImage(image.width, image.height, 3, PixelType::srgb8);
    for (std::size_t i = 0; i < std::size_t(image.width) * image.height; ++i) {
        std::copy_n(image.bytes() + i * image.channels, 3, rgb.bytes() + i * 3);
    }
    return rgb;
}

TEST(ImageJpeg, RoundTripIsUprightAndClose) {
    for (const std::uint32_t channels : {3u, 4u}) {
        const Image image = gradient(64, 48, channels);
        const Image back = decodeJpeg(encodeJpeg(image, 100, false));
        EXPECT_TRUE(imagesMatch(back, withoutAlpha(image), kEdges));
    }
}

TEST(ImageJpeg, AlphaDoesNotReachTheFile) {
    Image seen = gradient(32, 32, 4), other = seen;
    for (std::size_t i = 3; i < other.data.size(); i += 4) other.bytes()[i] = 7;
    EXPECT_EQ(encodeJpeg(seen, 85, true), encodeJpeg(other, 85, true));
}

TEST(ImageJpeg, QualityAndSubsamplingReachTheFile) {
    const Image image = gradient(256, 256, 3);
    const Bytes low = encodeJpeg(image, 10, true), high = encodeJpeg(image, 95, true);
    EXPECT_LT(low.size(), high.size());
    // The frame header (marker FF C0 or C2): luma's sampling factors are 2x2 or 1x1.
    const auto lumaSampling = [](const Bytes& jpeg) {
        const std::size_t at = jpeg.find("\xff\xc0");
        return at == Bytes::npos ? 0 : static_cast<std::uint8_t>(jpeg[at + 11]);
    };
    EXPECT_EQ(lumaSampling(high), 0x22);
    EXPECT_EQ(lumaSampling(encodeJpeg(image, 95, false)), 0x11);
    // Beyond 1..100 the nearest stands in.
    EXPECT_EQ(encodeJpeg(image, 1000, true), encodeJpeg(image, 100, true));
    EXPECT_EQ(encodeJpeg(image, -5, true), encodeJpeg(image, 1, true));
}

TEST(ImageJpeg, SmallestAndOddSizes) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 3u}, {17u, 1u}}) {
        const Image back = decodeJpeg(encodeJpeg(gradient(width, height, 3), 90, true));
        EXPECT_EQ(back.width, width);
        EXPECT_EQ(back.height, height);
    }
}

TEST(ImagePng, IsLossless) {
    for (const std::uint32_t channels : {1u, 3u, 4u}) {
        const Image image = gradient(37, 21, channels);
        const Image back = decodePng(encodePng(image));
        ASSERT_EQ(back.channels, 4u);
        for (std::size_t i = 0; i < 37 * 21; ++i) {
            for (std::uint32_t c = 0; c < 4; ++c) {
                const std::uint8_t expected = c < channels ? image.bytes()[i * channels + c]
                                              : channels == 1 && c < 3 ? image.bytes()[i]
                                                                       : 255;
                ASSERT_EQ(back.bytes()[i * 4 + c], expected) << "pixel " << i << " channel " << c;
            }
        }
    }
}

TEST(ImageNpy, MatchesTheNumPySpecification) {
    Image image = makeImage(2, 1, 1, PixelType::float32);
    image.floats()[0] = 1.0f;
    image.floats()[1] = -2.5f;
    // 10 bytes of magic and length, 118 of header: the numbers start at 128, a multiple of 64.
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 1), }";
    header.resize(117, ' ');
    header += '\n';
    std::string expected("\x93NUMPY\x01\x00\x76\x00", 10);
    expected.append(header).append("\x00\x00\x80\x3f\x00\x00\x20\xc0", 8);
    EXPECT_EQ(encodeNpy(image), expected);
}

TEST(ImageNpy, IsLossless) {
    for (const std::uint32_t channels : {1u, 3u, 4u}) {
        const Image image = hardFloats(channels);
        const Image back = decodeNpy(encodeNpy(image));
        EXPECT_EQ(back.width, 3u);
        EXPECT_EQ(back.height, 2u);
        EXPECT_EQ(back.channels, channels);
        EXPECT_EQ(back.data, image.data);
    }
}

TEST(ImageExr, AnotherReaderFindsTheSameValues) {
    for (const std::uint32_t channels : {1u, 3u, 4u}) {
        const Image image = hardFloats(channels);
        const Bytes bytes = encodeExr(image);
        const auto* memory = reinterpret_cast<const unsigned char*>(bytes.data());
        const char* error = nullptr;
        EXRVersion version;
        ASSERT_EQ(ParseEXRVersionFromMemory(&version, memory, bytes.size()), TINYEXR_SUCCESS);
        EXRHeader header;
        InitEXRHeader(&header);
        ASSERT_EQ(ParseEXRHeaderFromMemory(&header, &version, memory, bytes.size(), &error),
                  TINYEXR_SUCCESS);
        EXRImage read;
        InitEXRImage(&read);
        ASSERT_EQ(LoadEXRImageFromMemory(&read, &header, memory, bytes.size(), &error),
                  TINYEXR_SUCCESS);
        ASSERT_EQ(read.width, 3);
        ASSERT_EQ(read.height, 2);
        ASSERT_EQ(read.num_channels, static_cast<int>(channels));
        const std::string order = channels == 1 ? "Y" : "RGBA";  // ours
        for (int c = 0; c < read.num_channels; ++c) {
            EXPECT_EQ(header.pixel_types[c], TINYEXR_PIXELTYPE_FLOAT);
            const std::size_t ours = order.find(header.channels[c].name);
            ASSERT_NE(ours, std::string::npos);
            for (std::size_t i = 0; i < 6; ++i) {
                EXPECT_EQ(reinterpret_cast<const float*>(read.images[c])[i],
                          image.floats()[i * channels + ours]);
            }
        }
        FreeEXRImage(&read);
        FreeEXRHeader(&header);
    }
}

TEST(ImageErrors, InvalidImagesAreRejectedWithAMessage) {
    const Image floats = hardFloats(3), empty = makeImage(0, 0, 3, PixelType::srgb8);
    Image torn = gradient(4, 4, 3);
    torn.data.resize(5);
    EXPECT_THROW(encodeJpeg(floats, 85, true), std::runtime_error);
    EXPECT_THROW(encodeJpeg(empty, 85, true), std::runtime_error);
    EXPECT_THROW(encodeJpeg(torn, 85, true), std::runtime_error);
    EXPECT_THROW(encodeJpeg(gradient(4, 4, 1), 85, true), std::runtime_error);
    EXPECT_THROW(encodePng(floats), std::runtime_error);
    EXPECT_THROW(encodePng(torn), std::runtime_error);
    EXPECT_THROW(encodeNpy(gradient(4, 4, 3)), std::runtime_error);
    EXPECT_THROW(encodeExr(gradient(4, 4, 3)), std::runtime_error);
    EXPECT_THROW(makeImage(1, 1, 2, PixelType::srgb8), std::runtime_error);
}

// Every prefix of a good file, and the file with one byte changed, is read or refused; nothing
// else.
template <class Decode>
void survivesDamage(const Bytes& good, Decode&& decode) {
    for (std::size_t length = 0; length < good.size(); ++length) {
        const std::string cut(good, 0, length);  // of exactly this size, for the sanitizers
        try {
            decode(cut);
        } catch (const std::runtime_error&) {
        }
        std::string changed = good;
        changed[length] = static_cast<char>(changed[length] ^ 0x55);
        try {
            decode(changed);
        } catch (const std::runtime_error&) {
        }
    }
}

TEST(ImageErrors, DamagedFilesAreReadOrRejected) {
    survivesDamage(encodeJpeg(gradient(9, 8, 3), 60, true), decodeJpeg);
    survivesDamage(encodePng(gradient(9, 8, 4)), decodePng);
    survivesDamage(encodeNpy(hardFloats(3)), decodeNpy);
    EXPECT_THROW(decodeJpeg(""), std::runtime_error);
    EXPECT_THROW(decodePng("\x89PNG\r\n\x1a\n"), std::runtime_error);
    EXPECT_THROW(decodeNpy("no array at all"), std::runtime_error);
}

template <class Decode>
std::string refusal(const Bytes& bytes, Decode&& decode) {
    try {
        decode(bytes);
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return "read";
}

TEST(ImageErrors, OversizedClaimsAreRejectedBeforeAllocation) {
    Bytes jpeg = encodeJpeg(gradient(8, 8, 3), 85, false);
    const std::size_t frame = jpeg.find("\xff\xc0");
    ASSERT_NE(frame, Bytes::npos);
    jpeg.replace(frame + 5, 4, "\xfd\xe8\xfd\xe8");  // 65000 x 65000
    EXPECT_EQ(refusal(jpeg, decodeJpeg),
              "JPEG: cannot decode 65000 x 65000 pixels: too large or empty");

    Bytes npy = encodeNpy(hardFloats(1));
    const std::size_t shape = npy.find("(2, 3, 1), }        ");
    ASSERT_NE(shape, Bytes::npos);
    npy.replace(shape, 20, "(65536, 65536, 4), }");
    EXPECT_EQ(refusal(npy, decodeNpy), "NPY: cannot read: its size does not match its shape");
}

TEST(ImageThreads, EncodeLikeASingleThread) {
    const Image image = gradient(200, 100, 4);
    const Bytes jpeg = encodeJpeg(image, 85, true), png = encodePng(image);
    std::vector<std::future<bool>> results;
    for (int thread = 0; thread < 4; ++thread) {
        results.push_back(std::async(std::launch::async, [&] {
            bool same = true;
            for (int i = 0; i < 10; ++i) {
                same &= encodeJpeg(image, 85, true) == jpeg && encodePng(image) == png;
            }
            return same;
        }));
    }
    for (auto& result : results) EXPECT_TRUE(result.get());
}

// Read back by the library's decoder: near the original, nearer with more quality, smaller than
// PNG.
TEST(Webp, ComesBackNearTheOriginal) {
    Image image = makeImage(97, 61, 4, PixelType::srgb8);
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            std::uint8_t* p = image.bytes() + 4 * (y * image.width + x);
            p[0] = static_cast<std::uint8_t>(2 * x);
            p[1] = static_cast<std::uint8_t>(4 * y);
            p[2] = static_cast<std::uint8_t>(128 + x - y);
            p[3] = 255;
        }
    }
    double before = 1e9;
    for (const int quality : {10, 60, 95}) {
        const Bytes file = encodeWebp(image, quality);
        EXPECT_EQ(file, encodeWebp(image, quality)) << "the same bytes";
        int width = 0, height = 0;
        std::uint8_t* pixels = WebPDecodeRGB(reinterpret_cast<const std::uint8_t*>(file.data()),
                                             file.size(), &width, &height);
        ASSERT_TRUE(pixels);
        ASSERT_EQ(width, 97);
        ASSERT_EQ(height, 61);
        double sum = 0.0;
        for (std::size_t i = 0; i < 97 * 61; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                sum += std::abs(pixels[3 * i + k] - image.bytes()[4 * i + k]);
            }
        }
        WebPFree(pixels);
        const double mean = sum / (3 * 97 * 61);
        EXPECT_LT(mean, 6.0) << quality;
        EXPECT_LT(mean, before) << quality;
        before = mean;
    }
    EXPECT_THROW(encodeWebp(makeImage(8, 8, 1, PixelType::srgb8), 80), std::invalid_argument);
    EXPECT_THROW(encodeWebp(makeImage(8, 8, 3, PixelType::float32), 80), std::invalid_argument);
}

}  // namespace
}  // namespace clerestory::test
