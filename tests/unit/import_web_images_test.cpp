// WebP and AVIF textures: lossless ones come back exactly, damaged and oversized ones give one
// clear reason, and glTF prefers them to the fallback.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "scene/import/textures/image_decoder.h"

#include <avif/avif.h>
#include <gmock/gmock.h>
#include <webp/encode.h>
#include <nlohmann/json.hpp>

#include <random>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr std::uint64_t kMany = 1'000'000;

struct Pixels {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

Pixels noise(std::uint32_t width, std::uint32_t height) {
    std::mt19937 random(width);
    Pixels pixels{width, height, {}};
    for (std::uint32_t i = 0; i < 4 * width * height; ++i) {
        pixels.rgba.push_back(static_cast<std::uint8_t>(random()));
    }
    // Encoders may forget the colour of pixels without alpha.
    for (std::size_t i = 3; i < pixels.rgba.size(); i += 4) pixels.rgba[i] |= 1;
    return pixels;
}

std::string webpOf(const Pixels& pixels) {
    std::uint8_t* bytes = nullptr;
    const std::size_t size = WebPEncodeLosslessRGBA(
        pixels.rgba.data(), static_cast<int>(pixels.width), static_cast<int>(pixels.height),
        static_cast<int>(4 * pixels.width), &bytes);
    std::string file(reinterpret_cast<const char*>(bytes), size);
    WebPFree(bytes);
    return file;
}

// Red, green and blue as the three planes: no conversion, no loss.
std::string avifOf(const Pixels& pixels) {
    const std::unique_ptr<avifImage, void (*)(avifImage*)> image(
        avifImageCreate(static_cast<int>(pixels.width), static_cast<int>(pixels.height), 8,
                        AVIF_PIXEL_FORMAT_YUV444),
        avifImageDestroy);
    image->matrixCoefficients = AVIF_MATRIX_COEFFICIENTS_IDENTITY;
    image->yuvRange = AVIF_RANGE_FULL;
    avifRGBImage rgb;
    avifRGBImageSetDefaults(&rgb, image.get());
    rgb.depth = 8;
    rgb.format = AVIF_RGB_FORMAT_RGBA;
    rgb.pixels = const_cast<std::uint8_t*>(pixels.rgba.data());
    rgb.rowBytes = 4 * pixels.width;
    EXPECT_EQ(avifImageRGBToYUV(image.get(), &rgb), AVIF_RESULT_OK);
    const std::unique_ptr<avifEncoder, void (*)(avifEncoder*)> encoder(avifEncoderCreate(),
                                                                       avifEncoderDestroy);
    encoder->minQuantizer = encoder->maxQuantizer = AVIF_QUANTIZER_LOSSLESS;
    encoder->minQuantizerAlpha = encoder->maxQuantizerAlpha = AVIF_QUANTIZER_LOSSLESS;
    encoder->speed = AVIF_SPEED_FASTEST;
    avifRWData out = AVIF_DATA_EMPTY;
    EXPECT_EQ(avifEncoderWrite(encoder.get(), image.get(), &out), AVIF_RESULT_OK);
    std::string file(reinterpret_cast<const char*>(out.data), out.size);
    avifRWDataFree(&out);
    return file;
}

TextureImage decoded(const std::string& file, std::uint64_t most = kMany) {
    std::atomic<std::uint64_t> left{most};
    return decodedImage({reinterpret_cast<const unsigned char*>(file.data()), file.size()}, most,
                        left);
}

class WebImages : public testing::TestWithParam<std::string (*)(const Pixels&)> {};
INSTANTIATE_TEST_SUITE_P(Formats, WebImages, testing::Values(webpOf, avifOf),
                         [](const auto& p) { return p.index == 0 ? "Webp" : "Avif"; });

TEST_P(WebImages, LosslessOnesComeBackExactly) {
    const Pixels pixels = noise(37, 23);
    const TextureImage image = decoded(GetParam()(pixels));
    EXPECT_EQ(image.width, 37u);
    EXPECT_EQ(image.height, 23u);
    EXPECT_TRUE(std::equal(image.texels.begin(), image.texels.end(), pixels.rgba.begin(),
                           pixels.rgba.end()));
}

TEST_P(WebImages, SizesAreCheckedBeforeDecoding) {
    const std::string file = GetParam()(noise(40, 30));
    EXPECT_NO_THROW(decoded(file, 1200));
    try {
        decoded(file, 1199);
        FAIL() << "it was decoded";
    } catch (const ImportError& error) {
        EXPECT_EQ(error.reason(), ImportError::Reason::limit);
        EXPECT_THAT(error.what(), HasSubstr("40 x 30"));
    }
}

TEST_P(WebImages, DamagedOnesGiveAPictureOrAReason) {
    const std::string whole = GetParam()(noise(29, 31));
    std::mt19937 random(5);
    int refused = 0;
    for (int seed = 0; seed < 300; ++seed) {
        std::string file = whole;
        if (seed % 3 == 0) file.resize(random() % file.size());
        for (int k = 0; k < seed % 5 && !file.empty(); ++k) {
            file[random() % file.size()] = static_cast<char>(random());
        }
        try {
            decoded(file, 10'000);
        } catch (const ImportError& error) {
            EXPECT_NE(std::string(error.what()), "");
            ++refused;
        }
    }
    EXPECT_GT(refused, 50);
}

// In the importer's process with its confinement, before the fallback, which is missing here.
TEST_P(WebImages, GltfTexturesUseThem) {
    const TemporaryFolder folder;
    const Pixels pixels = noise(16, 16);
    const bool isWebp = GetParam() == webpOf;
    folder.write("picture.bin", GetParam()(pixels));
    json document = json::parse(triangleGltf());
    const char* extension = isWebp ? "EXT_texture_webp" : "EXT_texture_avif";
    document["extensionsRequired"] = document["extensionsUsed"] = {extension};
    document["images"] = {{{"uri", "missing.png"}}, {{"uri", "picture.bin"}}};
    document["textures"] = {{{"source", 0}, {"extensions", {{extension, {{"source", 1}}}}}}};
    document["materials"] = {
        {{"name", "m"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    for (json& mesh : document["meshes"]) {
        for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
    }
    const Scene scene = importScene(folder.write("scene.gltf", document.dump()));
    EXPECT_FALSE(warning(scene, "missingTexture") || warning(scene, "brokenTexture") ||
                 warning(scene, "unsupportedExtension"));
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_TRUE(std::equal(pixels.rgba.begin(), pixels.rgba.end(), scene.images[0].texels.begin()));
}

}  // namespace
}  // namespace clerestory::test
