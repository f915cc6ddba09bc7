// KTX2 textures: files of the reference encoder of Basis Universal give the texels that its decoder
// gives, which are stored next to them as PNG.
#include "image/image.h"
#include "scene/import/textures/uastc_block.h"
#include "tests/unit/texture_support.h"

#include <zstd.h>

namespace clerestory::test {
namespace {

using nlohmann::json;

std::string storedFile(const std::string& name) {
    const auto path = std::filesystem::path(CLERESTORY_SOURCE_DIR) / "tests/scenes/textures" / name;
    std::ifstream stream(path, std::ios::binary);
    EXPECT_TRUE(stream.good()) << path;
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// etc1s has a size that is no multiple of 4; etc1s-alpha has levels; each row of blocks of
// uastc-modes has one of the 19 modes, with all partition patterns.
constexpr const char* kFiles[] = {"etc1s", "etc1s-alpha", "uastc-zstandard", "uastc-modes"};

TEST(Ktx2, TexelsAreThoseOfTheReferenceDecoder) {
    for (const std::string name : kFiles) {
        const TextureImage image = decoded(storedFile(name + ".ktx2"));
        const Image truth = decodePng(storedFile(name + ".png"));
        ASSERT_EQ(image.width, truth.width) << name;
        ASSERT_EQ(image.height, truth.height) << name;
        ASSERT_EQ(image.texels.size(), truth.data.size()) << name;
        EXPECT_TRUE(std::equal(image.texels.begin(), image.texels.end(), truth.bytes())) << name;
    }
}

TEST(Ktx2, TheExtensionIsPreferredToTheFallback) {
    for (const bool hasFallback : {true, false}) {
        const TemporaryFolder folder;
        const auto file = folder.write("scene.glb", texturedGlb([&](GlbBuilder& b, json& texture) {
                                           if (hasFallback)
                                               texture["source"] =
                                                   image(b, storedFile("etc1s.png"));
                                           texture["extensions"]["KHR_texture_basisu"]["source"] =
                                               image(b, storedFile("etc1s-alpha.ktx2"));
                                           b.json()["extensionsRequired"] = {"KHR_texture_basisu"};
                                           b.json()["extensionsUsed"] = {"KHR_texture_basisu"};
                                       }));
        const Scene scene = importScene(file);  // in the confined child process
        ASSERT_EQ(scene.images.size(), 1u);
        EXPECT_EQ(scene.images[0].width, 64u);
        EXPECT_TRUE(scene.images[0].hasAlpha);
        EXPECT_TRUE(scene.warnings.empty());
    }
}

// The file with a number of the header changed.
std::string changedHeader(const char* name, std::size_t at, std::uint32_t value) {
    std::string file = storedFile(name);
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(value >> 8 * i);
    return file;
}

TEST(Ktx2, HeadersAreCheckedBeforeDecoding) {
    constexpr std::size_t kFormat = 12, kWidth = 20, kHeight = 24, kLayers = 32, kFaces = 36,
                          kLevels = 40, kScheme = 44, kGlobalData = 64, kLevelOffset = 80,
                          kLevelSize = 88;
    const std::string damaged = "malformed: the KTX2 texture is damaged: ",
                      formats =
                          "unsupported: KTX2 textures with other formats than UASTC, with or "
                          "without Zstandard, and ETC1S are not supported",
                      layers =
                          "unsupported: KTX2 textures with layers, faces or depth are not "
                          "supported";
    const struct {
        const char* file;
        std::size_t at;
        std::uint32_t value;
        std::string error;
    } rows[] = {
        {"etc1s.ktx2", kWidth, 0, "malformed: the image has no pixels"},
        {"etc1s.ktx2", kWidth, 65536, "limit: the image of 65536 x 29 pixels exceeds the limit"},
        {"uastc-modes.ktx2", kHeight, 4000000000u,
         "limit: the image of 128 x 4000000000 pixels exceeds the limit"},
        {"uastc-modes.ktx2", kHeight, 80, damaged + "its level has too few bytes"},
        {"uastc-zstandard.ktx2", kHeight, 80,
         damaged + "its Zstandard data is not of the size of the image"},
        {"uastc-zstandard.ktx2", kHeight, 8,
         damaged + "its Zstandard data is not of the size of the image"},
        {"etc1s.ktx2", kFormat, 37, formats},
        {"etc1s.ktx2", kScheme, 0, formats},
        {"etc1s.ktx2", kScheme, 3, formats},
        {"uastc-modes.ktx2", kScheme, 1, formats},
        {"etc1s.ktx2", kLayers, 2, layers},
        {"etc1s.ktx2", kFaces, 6, layers},
        {"etc1s.ktx2", kLevels, 33, damaged + "it has more than 32 levels"},
        {"etc1s.ktx2", kLevels, 32, damaged + "a part of it is missing"},
        {"etc1s.ktx2", kGlobalData, 1u << 31, damaged + "a part of it is missing"},
        {"etc1s.ktx2", kLevelOffset, 1u << 31, damaged + "a part of it is missing"},
        {"etc1s.ktx2", kLevelSize, 1u << 31, damaged + "a part of it is missing"},
    };
    for (const auto& row : rows) {
        EXPECT_EQ(errorOfImage(changedHeader(row.file, row.at, row.value)), row.error)
            << row.file << " " << row.at;
    }
    EXPECT_EQ(errorOfImage(storedFile("etc1s.ktx2").substr(0, 40)),
              damaged + "its header ends early");
}

TEST(Ktx2, UnknownBlocksAreRejected) {
    std::array<unsigned char, kUastcBlockBytes> block{0x45};
    EXPECT_FALSE(decodedUastc(block)) << "the reserved mode";
    block = {0x1D, 0xFF, 0xFF, 0xFF};
    EXPECT_FALSE(decodedUastc(block)) << "pattern 31 of 30";
}

// 256 MB of zeros in place of the blocks of a small image.
TEST(Ktx2, CompressedZerosDoNotExpand) {
    const std::string zeros(256u << 20, '\0');
    std::string compressed(ZSTD_compressBound(zeros.size()), '\0');
    compressed.resize(
        ZSTD_compress(compressed.data(), compressed.size(), zeros.data(), zeros.size(), 1));
    std::string file = storedFile("uastc-zstandard.ktx2");
    const std::size_t at = file.size();
    file += compressed;
    const auto put = [&](std::size_t field, std::uint64_t value) {
        for (std::size_t i = 0; i < 8; ++i) file[field + i] = static_cast<char>(value >> 8 * i);
    };
    put(80, at);
    put(88, compressed.size());
    put(96, zeros.size());
    EXPECT_EQ(errorOfImage(file),
              "malformed: the KTX2 texture is damaged: its Zstandard data is not of the size of "
              "the image");
}

TEST(Ktx2, DamagedFilesDoNoHarm) {
    for (const std::string name : kFiles) {
        const std::string file = storedFile(name + ".ktx2");
        unsigned errors = 0;
        for (unsigned seed = 0; seed < 500; ++seed) {
            const std::string error = errorOfImage(damagedStream(file, seed));
            errors += error != "was decoded";
            EXPECT_LT(error.size(), 200u);
        }
        EXPECT_GT(errors, 0u);
    }
}

}  // namespace
}  // namespace clerestory::test
