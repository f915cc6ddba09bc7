// WebP and AVIF textures: images of the libraries' encoders give the texels that were encoded.
#include "image/image.h"
#include "tests/unit/texture_support.h"

#include <avif/avif.h>
#include <webp/encode.h>

#include <cmath>
#include <memory>

namespace clerestory::test {
namespace {

using nlohmann::json;

struct Picture {
    std::uint32_t width, height;
    std::vector<std::uint8_t> rgba;
};

Picture gradient(std::uint32_t width, std::uint32_t height) {
    Picture picture{width, height, {}};
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            for (const std::uint32_t value : {255 * x / width, 255 * y / height,
                                              127 + 127 * (x / 8 + y / 8) % 2, 255 - x % 200}) {
                picture.rgba.push_back(static_cast<std::uint8_t>(value));
            }
        }
    }
    return picture;
}

std::string webp(const Picture& picture, float quality) {  // above 100: lossless
    std::uint8_t* bytes = nullptr;
    const int width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
    const std::size_t size =
        quality > 100.0f
            ? WebPEncodeLosslessRGBA(picture.rgba.data(), width, height, 4 * width, &bytes)
            : WebPEncodeRGBA(picture.rgba.data(), width, height, 4 * width, quality, &bytes);
    const std::string file(reinterpret_cast<const char*>(bytes), size);
    WebPFree(bytes);
    return file;
}

struct AvifOptions {
    std::uint32_t depth = 8;
    bool lossless = true;
    bool rotated = false;
};

std::string avif(const Picture& picture, const AvifOptions& options = {}) {
    const std::unique_ptr<avifImage, void (*)(avifImage*)> image(avifImageCreateEmpty(),
                                                                 avifImageDestroy);
    image->width = picture.width;
    image->height = picture.height;
    image->depth = options.depth;
    image->yuvFormat = options.lossless ? AVIF_PIXEL_FORMAT_YUV444 : AVIF_PIXEL_FORMAT_YUV420;
    image->matrixCoefficients =
        options.lossless ? AVIF_MATRIX_COEFFICIENTS_IDENTITY : AVIF_MATRIX_COEFFICIENTS_BT601;
    if (options.rotated) {
        image->transformFlags = AVIF_TRANSFORM_IROT;
        image->irot.angle = 1;
    }
    avifRGBImage rgb;
    avifRGBImageSetDefaults(&rgb, image.get());
    rgb.depth = 8;
    std::vector<std::uint8_t> pixels = picture.rgba;
    rgb.pixels = pixels.data();
    rgb.rowBytes = 4 * picture.width;
    EXPECT_EQ(avifImageRGBToYUV(image.get(), &rgb), AVIF_RESULT_OK);
    const std::unique_ptr<avifEncoder, void (*)(avifEncoder*)> encoder(avifEncoderCreate(),
                                                                       avifEncoderDestroy);
    encoder->maxThreads = 1;
    encoder->speed = 10;
    encoder->minQuantizer = encoder->maxQuantizer = options.lossless ? 0 : 20;
    encoder->minQuantizerAlpha = encoder->maxQuantizerAlpha = options.lossless ? 0 : 20;
    avifRWData bytes = AVIF_DATA_EMPTY;
    EXPECT_EQ(avifEncoderWrite(encoder.get(), image.get(), &bytes), AVIF_RESULT_OK);
    const std::string file(reinterpret_cast<const char*>(bytes.data), bytes.size);
    avifRWDataFree(&bytes);
    return file;
}

// The largest difference of a channel, and the mean.
std::pair<int, double> differences(const TextureImage& image, const Picture& picture) {
    EXPECT_EQ(image.width, picture.width);
    EXPECT_EQ(image.height, picture.height);
    if (image.texels.size() != picture.rgba.size()) return {255, 255.0};
    int most = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < image.texels.size(); ++i) {
        const int d = std::abs(int{image.texels[i]} - int{picture.rgba[i]});
        most = std::max(most, d);
        sum += d;
    }
    return {most, sum / static_cast<double>(image.texels.size())};
}

TEST(CompressedTextures, LosslessImagesAreExact) {
    for (const Picture& picture : {gradient(1, 1), gradient(37, 29), gradient(128, 64)}) {
        EXPECT_EQ(differences(decoded(webp(picture, 101)), picture).first, 0);
        EXPECT_EQ(differences(decoded(avif(picture)), picture).first, 0);
        EXPECT_EQ(differences(decoded(avif(picture, {.depth = 10})), picture).first, 0);
        EXPECT_EQ(differences(decoded(avif(picture, {.depth = 12})), picture).first, 0);
    }
}

TEST(CompressedTextures, LossyImagesAreSimilar) {
    const Picture picture = gradient(128, 64);
    EXPECT_LT(differences(decoded(webp(picture, 90)), picture).second, 3.0);
    EXPECT_LT(differences(decoded(avif(picture, {.lossless = false})), picture).second, 3.0);
}

TEST(CompressedTextures, ExtensionsArePreferredToTheFallback) {
    const Picture preferred = gradient(16, 8), fallback = gradient(4, 4);
    const std::pair<const char*, std::string> rows[] = {{"EXT_texture_webp", webp(preferred, 101)},
                                                        {"EXT_texture_avif", avif(preferred)}};
    for (const auto& [name, bytes] : rows) {
        for (const bool hasFallback : {true, false}) {
            const Scene scene = importedGlb(texturedGlb([&](GlbBuilder& b, json& texture) {
                if (hasFallback) texture["source"] = image(b, webp(fallback, 101));
                texture["extensions"][name]["source"] = image(b, bytes);
                b.json()["extensionsRequired"] = {name};
                b.json()["extensionsUsed"] = {name};
            }));
            ASSERT_EQ(scene.images.size(), 1u) << name;
            EXPECT_EQ(scene.images[0].width, 16u) << name;
            EXPECT_TRUE(scene.images[0].hasAlpha);
            EXPECT_TRUE(scene.warnings.empty());
        }
    }
}

// In the confined child process, where a decoder may not start processes or open files.
TEST(CompressedTextures, AreDecodedByTheChildProcess) {
    const Picture picture = gradient(640, 480);
    for (const std::string& bytes : {webp(picture, 80), avif(picture, {.lossless = false})}) {
        const TemporaryFolder folder;
        const Scene scene =
            importScene(folder.write("scene.glb", texturedGlb([&](GlbBuilder& b, json& texture) {
                                         texture["source"] = image(b, bytes);
                                     })));
        ASSERT_EQ(scene.images.size(), 1u);
        EXPECT_EQ(scene.images[0].width, 640u);
    }
}

TEST(CompressedTextures, ADamagedImageIsAWarning) {
    const Scene scene = importedGlb(texturedGlb([&](GlbBuilder& b, json& texture) {
        texture["extensions"]["EXT_texture_webp"]["source"] =
            image(b, webp(gradient(16, 8), 101).substr(0, 40));
    }));
    EXPECT_TRUE(scene.images.empty());
    ASSERT_TRUE(warning(scene, "brokenTexture"));
    EXPECT_EQ(warning(scene, "brokenTexture")->message, "the WebP image is damaged");
}

std::string bigEndian(std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
}

// An AVIF file whose container declares another size.
std::string resizedAvif(std::uint32_t width, std::uint32_t height) {
    std::string file = avif(gradient(16, 8));
    for (std::size_t at = file.find("ispe"); at != std::string::npos;
         at = file.find("ispe", at + 1)) {
        file.replace(at + 8, 8, bigEndian(width) + bigEndian(height));
    }
    return file;
}

TEST(CompressedTextures, SizesAreCheckedBeforeDecoding) {
    // Headers of images of 16383 x 16383 pixels, lossless, and of an animation.
    const std::string huge("RIFF\x1e\0\0\0WEBPVP8L\x12\0\0\0\x2f\xfe\xff\xff\x0f\0\0\0\0\0\0", 32);
    const std::string animation("RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x0f\0\0\x07\0\0", 30);
    EXPECT_EQ(errorOfImage(huge), "limit: the image of 16383 x 16384 pixels exceeds the limit");
    EXPECT_EQ(errorOfImage(animation), "unsupported: animated WebP images are not supported");
    EXPECT_EQ(errorOfImage(webp(gradient(16, 8), 101), 127),
              "limit: the image of 16 x 8 pixels exceeds the limit");
    EXPECT_EQ(errorOfImage(avif(gradient(16, 8)), 127),
              "limit: the image of 16 x 8 pixels exceeds the limit");
    EXPECT_EQ(errorOfImage(resizedAvif(16000, 16000)),
              "limit: the image of 16000 x 16000 pixels exceeds the limit");
    EXPECT_EQ(errorOfImage(resizedAvif(4'000'000'000u, 4'000'000'000u)),
              "malformed: the AVIF image is damaged or too large");
    EXPECT_EQ(errorOfImage(resizedAvif(8, 8), 100), "malformed: the AVIF image is damaged");
    EXPECT_EQ(errorOfImage(avif(gradient(16, 8), {.rotated = true})),
              "unsupported: AVIF images that are to be cropped, rotated or mirrored are not "
              "supported");
}

TEST(CompressedTextures, DamagedImagesDoNoHarm) {
    const Picture picture = gradient(64, 48);
    for (const std::string& file : {webp(picture, 101), webp(picture, 80), avif(picture),
                                    avif(picture, {.lossless = false})}) {
        unsigned errors = 0;
        for (unsigned seed = 0; seed < 300; ++seed) {
            const std::string error = errorOfImage(damagedStream(file, seed));
            errors += error != "was decoded";
            EXPECT_LT(error.size(), 200u);
        }
        EXPECT_GT(errors, 0u);
    }
}

// Compared with the usual formats of textures.
TEST(CompressedTextures, LoadTimes) {
    const Picture picture = gradient(1024, 1024);
    Image pixels = makeImage(1024, 1024, 4, PixelType::srgb8);
    std::copy(picture.rgba.begin(), picture.rgba.end(), pixels.bytes());
    const auto glb = [](const std::string& bytes) {
        return texturedGlb(
            [&](GlbBuilder& b, json& texture) { texture["source"] = image(b, bytes); });
    };
    const std::string png = glb(encodePng(pixels)), jpeg = glb(encodeJpeg(pixels, 80, true));
    reportLoadTimes("lossless WebP (without: PNG)", glb(webp(picture, 101)), png);
    reportLoadTimes("WebP (without: JPEG)", glb(webp(picture, 80)), jpeg);
    reportLoadTimes("AVIF (without: JPEG)", glb(avif(picture, {.lossless = false})), jpeg);
}

}  // namespace
}  // namespace clerestory::test
