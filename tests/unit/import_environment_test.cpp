// Environment maps from every container give the same radiance in every direction; malicious files
// are rejected.
#include "image/image.h"
#include "scene/import/textures/cube_file.h"
#include "scene/import/textures/environment_reader.h"
#include "tests/support/ktx_files.h"
#include "tests/unit/import_support.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <random>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using test::Cube;
using test::KtxFormat;
using testing::HasSubstr;

// Tells every direction from every other, and no mirror image or turn of it is the same.
glm::vec3 lightFrom(const glm::vec3& direction) {
    const glm::vec3 d = glm::normalize(direction);
    return glm::vec3(0.5f) + 0.4f * glm::vec3(d.x, d.y, d.z) + glm::vec3(0, 0, 0.1f * d.x * d.y);
}

Cube analyticCube(std::uint32_t size) {
    Cube cube{size, {}};
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < size; ++y) {
            for (std::uint32_t x = 0; x < size; ++x) {
                cube.texels.push_back(lightFrom(cubeTexelDirection(face, x, y, size)));
            }
        }
    }
    return cube;
}

// The centres and upper edges of faces by OpenGL's table, written by hand: the
// first row of +X is up, and its left column is +Z.
TEST(Cube, FacesFollowTheOpenGlConvention) {
    const auto direction = [](std::uint32_t face, std::uint32_t x, std::uint32_t y) {
        return cubeTexelDirection(face, x, y, 4);
    };
    const float e = 0.75f;
    EXPECT_EQ(direction(0, 1, 2), glm::vec3(1, -0.25f, 0.25f));
    EXPECT_EQ(direction(0, 0, 0), glm::vec3(1, e, e));
    EXPECT_EQ(direction(1, 0, 0), glm::vec3(-1, e, -e));
    EXPECT_EQ(direction(2, 0, 0), glm::vec3(-e, 1, -e));
    EXPECT_EQ(direction(3, 0, 0), glm::vec3(-e, -1, e));
    EXPECT_EQ(direction(4, 0, 0), glm::vec3(-e, e, 1));
    EXPECT_EQ(direction(5, 0, 0), glm::vec3(e, e, -1));
}

// `error` on each channel of each texel.
void expectAnalytic(const EnvironmentMap& map, double error, const std::string& about) {
    ASSERT_GT(map.faceSize, 0u) << about;
    ASSERT_EQ(map.texels.size(), std::size_t{6} * map.faceSize * map.faceSize);
    double worst = 0.0;
    std::size_t i = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x, ++i) {
                const glm::vec3 expected = lightFrom(cubeTexelDirection(face, x, y, map.faceSize));
                for (int c = 0; c < 3; ++c) {
                    worst = std::max<double>(worst, std::abs(map.texels[i][c] - expected[c]));
                }
            }
        }
    }
    EXPECT_LT(worst, error) << about;
}

std::string text(const Cube& cube, KtxFormat format, bool second) {
    return second ? test::ktx2File(cube, format) : test::ktx1File(cube, format);
}

Image linearImage(std::uint32_t width, std::uint32_t height,
                  const std::function<glm::vec3(std::uint32_t, std::uint32_t)>& at) {
    Image image = makeImage(width, height, 3, PixelType::float32);
    float* out = image.floats();
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x, out += 3) {
            const glm::vec3 color = at(x, y);
            std::copy(&color.x, &color.x + 3, out);
        }
    }
    return image;
}

// Once round from +Z over +X, and from straight up to straight down; -Z in the middle.
Image panorama(std::uint32_t width) {
    return linearImage(width, width / 2, [&](std::uint32_t x, std::uint32_t y) {
        const float turn = 6.28318531f * ((float(x) + 0.5f) / float(width) - 0.5f);
        const float fall = 3.14159265f * (float(y) + 0.5f) / float(width / 2);
        return lightFrom(
            {std::sin(fall) * std::sin(turn), std::cos(fall), -std::sin(fall) * std::cos(turn)});
    });
}

// Radiance's shared exponent, without run lengths.
std::string hdrFile(const Image& image) {
    std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                       " +X " + std::to_string(image.width) + "\n";
    const float* p = image.floats();
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height; ++i, p += 3) {
        int exponent = 0;
        std::frexp(std::max({p[0], p[1], p[2]}), &exponent);
        for (int c = 0; c < 3; ++c) {
            file += static_cast<char>(static_cast<int>(std::ldexp(p[c], 8 - exponent)));
        }
        file += static_cast<char>(exponent + 128);
    }
    return file;
}

TEST(ImportEnvironment, AllContainersGiveTheSameRadiance) {
    const TemporaryFolder folder;
    const Cube cube = analyticCube(16);
    expectAnalytic(loadEnvironment(folder.write("one.ktx", text(cube, KtxFormat::half4, false))),
                   1e-3, "KTX");
    expectAnalytic(loadEnvironment(folder.write("two.KTX2", text(cube, KtxFormat::half4, true))),
                   1e-3, "KTX2");
    expectAnalytic(loadEnvironment(folder.write("round.hdr", hdrFile(panorama(128)))), 0.03, "hdr");
    expectAnalytic(loadEnvironment(folder.write("round.exr", encodeExr(panorama(128)))), 0.01,
                   "exr");
    constexpr std::array kNames{"px", "nx", "py", "ny", "pz", "nz"};
    for (std::uint32_t face = 0; face < 6; ++face) {
        const Image image = linearImage(16, 16, [&](std::uint32_t x, std::uint32_t y) {
            return cube.texels[(std::size_t{face} * 16 + y) * 16 + x];
        });
        folder.write(std::string("exr/") + kNames[face] + ".exr", encodeExr(image));
        folder.write(std::string("hdr/") + kNames[face] + ".hdr", hdrFile(image));
        Image shown = makeImage(16, 16, 3, PixelType::srgb8);
        for (std::size_t i = 0; i < shown.data.size(); ++i) {
            const float c = image.floats()[i];
            shown.bytes()[i] = static_cast<std::uint8_t>(
                std::lround(255.0f * (1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f)));
        }
        folder.write(std::string("png/") + kNames[face] + ".png", encodePng(shown));
    }
    expectAnalytic(loadEnvironment(folder / "png"), 0.006, "six .png");
    expectAnalytic(loadEnvironment(folder / "exr"), 1e-6, "six .exr");
    expectAnalytic(loadEnvironment(folder / "hdr/"), 0.01, "six .hdr");
    EXPECT_EQ(loadEnvironment(folder / "hdr/").name, "hdr");
    EXPECT_EQ(loadEnvironment(folder / "one.ktx").name, "one");
    EXPECT_EQ(loadEnvironment(folder / "one.ktx").contentHash,
              loadEnvironment(folder / "two.KTX2").contentHash);
}

struct FormatRow {
    KtxFormat format;
    double error;
};
constexpr FormatRow kFormats[] = {{KtxFormat::unorm3, 0.5 / 255 + 1e-6},
                                  {KtxFormat::unorm4, 0.5 / 255 + 1e-6},
                                  {KtxFormat::bgr4, 0.5 / 255 + 1e-6},
                                  {KtxFormat::srgb4, 2.3 * 0.5 / 255},
                                  {KtxFormat::wide3, 1e-5},
                                  {KtxFormat::half3, 1e-3},
                                  {KtxFormat::half4, 1e-3},
                                  {KtxFormat::single3, 1e-7},
                                  {KtxFormat::single4, 1e-7},
                                  {KtxFormat::sharedExponent, 2e-3},
                                  {KtxFormat::small, 2e-2},
                                  {KtxFormat::bc1, 0.2}};

TEST(ImportEnvironment, EveryFormatOfTexelsIsRead) {
    const TemporaryFolder folder;
    for (const std::uint32_t size : {8u, 5u, 1u}) {  // rows with and without padding
        const Cube cube = analyticCube(size);
        for (const FormatRow& row : kFormats) {
            if (row.format == KtxFormat::bc1 && size != 8) continue;
            for (const bool second : {false, true}) {
                const std::string file = text(cube, row.format, second);
                const RadianceCube read = decodedCube(
                    {reinterpret_cast<const unsigned char*>(file.data()), file.size()}, 1'000'000);
                EnvironmentMap map;
                map.faceSize = read.faceSize;
                map.texels = read.texels;
                expectAnalytic(map, row.error,
                               "format " + std::to_string(static_cast<int>(row.format)) +
                                   (second ? " KTX2 " : " KTX ") + std::to_string(size));
            }
        }
    }
}

ImportError refusedMap(const std::filesystem::path& file, const ImportOptions& options = {}) {
    try {
        loadEnvironment(file, options);
    } catch (const ImportError& error) {
        return error;
    }
    ADD_FAILURE() << file << " was read";
    return {Reason::crashed, "was read"};
}

RadianceCube decoded(const std::string& file) {
    return decodedCube({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                       1'000'000);
}

void put32(std::string& file, std::size_t at, std::uint32_t value) {
    std::memcpy(file.data() + at, &value, 4);
}

TEST(ImportEnvironment, DdsCubesWithAndWithoutLevels) {
    struct Row {
        KtxFormat format;
        std::uint32_t dxgi;
        double error;
    };
    constexpr Row kRows[] = {{KtxFormat::srgb4, 0, 2.3 * 0.5 / 255},
                             {KtxFormat::half4, 0, 1e-3},
                             {KtxFormat::single4, 0, 1e-7},
                             {KtxFormat::unorm4, 28, 0.5 / 255 + 1e-6},
                             {KtxFormat::srgb4, 29, 2.3 * 0.5 / 255},
                             {KtxFormat::bgr4, 87, 0.5 / 255 + 1e-6},
                             {KtxFormat::half4, 10, 1e-3},
                             {KtxFormat::single3, 6, 1e-7},
                             {KtxFormat::single4, 2, 1e-7},
                             {KtxFormat::sharedExponent, 67, 2e-3},
                             {KtxFormat::small, 26, 2e-2},
                             {KtxFormat::bc1, 71, 0.2}};
    for (const std::uint32_t size : {8u, 5u, 1u}) {
        const Cube cube = analyticCube(size);
        for (const Row& row : kRows) {
            if (row.format == KtxFormat::bc1 && size != 8) continue;
            for (const std::uint32_t levels : {1u, 2u, 4u}) {
                if (levels > 1 && (size >> (levels - 1)) == 0) continue;
                if (levels > 1 && row.format == KtxFormat::bc1) continue;
                const RadianceCube read =
                    decoded(test::ddsFile(cube, row.format, row.dxgi, levels));
                EnvironmentMap map;
                map.faceSize = read.faceSize;
                map.texels = read.texels;
                expectAnalytic(map, row.error,
                               "DXGI " + std::to_string(row.dxgi) + " of format " +
                                   std::to_string(static_cast<int>(row.format)) + ", size " +
                                   std::to_string(size) + ", levels " + std::to_string(levels));
            }
        }
    }
    const TemporaryFolder folder;
    const Cube cube = analyticCube(16);
    EXPECT_EQ(
        loadEnvironment(folder.write("a.dds", test::ddsFile(cube, KtxFormat::half4, 0, 5)))
            .contentHash,
        loadEnvironment(folder.write("b.ktx", text(cube, KtxFormat::half4, false))).contentHash);
}

// Without a DX10 header eight bits are sRGB; the first of three or four bytes is red or blue.
TEST(ImportEnvironment, EightBitsOfDds) {
    Cube cube = analyticCube(2);
    const auto stored = decoded(test::ddsFile(cube, KtxFormat::unorm4, 28)).texels;
    for (const KtxFormat format : {KtxFormat::unorm3, KtxFormat::unorm4, KtxFormat::bgr4}) {
        const auto read = decoded(test::ddsFile(cube, format, 0)).texels;
        for (std::size_t i = 0; i < stored.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                const float s = stored[i][c];
                const float linear =
                    s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
                EXPECT_NEAR(read[i][c], linear, 1e-5f);
            }
        }
    }
}

// Two containers with the same blocks: 16 bytes a face are 2 x 2 texels of four bytes.
TEST(ImportEnvironment, BlocksOfDdsAreThoseOfKtx) {
    const Cube cube = analyticCube(2);
    std::mt19937 random(3);
    for (const auto& [dxgi, vulkan] :
         {std::pair(95u, 143u), std::pair(96u, 144u), std::pair(98u, 145u), std::pair(99u, 146u)}) {
        std::string dds = test::ddsFile(cube, KtxFormat::unorm4, dxgi);
        std::string ktx = test::ktx2File(cube, KtxFormat::unorm4);
        put32(dds, 12, 4);
        put32(dds, 16, 4);
        put32(ktx, 12, vulkan);
        put32(ktx, 20, 4);
        put32(ktx, 24, 4);
        for (std::size_t i = 0; i < 96; ++i) {
            dds[dds.size() - 96 + i] = ktx[ktx.size() - 96 + i] = static_cast<char>(random());
        }
        const auto a = decoded(dds), b = decoded(ktx);
        ASSERT_EQ(a.faceSize, 4u);
        EXPECT_EQ(std::memcmp(a.texels.data(), b.texels.data(), 96 * sizeof(glm::vec3)), 0);
    }
}

TEST(ImportEnvironment, WrongDdsFilesAreNamed) {
    const TemporaryFolder folder;
    const Cube cube = analyticCube(4);
    const auto refused = [&](std::string file, std::size_t at, std::uint32_t value) {
        put32(file, at, value);
        return refusedMap(folder.write("map.dds", file));
    };
    const std::string plain = test::ddsFile(cube, KtxFormat::half4, 0, 3);
    const std::string dx10 = test::ddsFile(cube, KtxFormat::half4, 10, 3);
    EXPECT_THAT(refused(plain, 0, 0).what(), HasSubstr("neither KTX nor KTX2 nor DDS"));
    EXPECT_THAT(refused(plain, 4, 123).what(), HasSubstr("header of another size"));
    EXPECT_THAT(refused(plain, 112, 0).what(), HasSubstr("no cube map: it has 1 faces"));
    EXPECT_THAT(refused(plain, 112, 0x7E00).what(), HasSubstr("no cube map"));
    EXPECT_THAT(refused(plain, 84, 0x31495441).what(), HasSubstr("DDS code 0x31495441"));  // ATI1
    EXPECT_THAT(refused(plain, 80, 0x20000).what(), HasSubstr("DDS with 0 bits"));
    EXPECT_THAT(refused(plain, 28, 4).what(), HasSubstr("more levels"));
    EXPECT_THAT(refused(plain, 28, 0xFFFFFFFF).what(), HasSubstr("more levels"));
    EXPECT_THAT(refused(plain, 12, 8).what(), HasSubstr("not square"));
    EXPECT_THAT(refused(dx10, 128, 41).what(), HasSubstr("DXGI_FORMAT 41"));
    EXPECT_THAT(refused(dx10, 136, 0).what(), HasSubstr("no cube map"));
    EXPECT_THAT(refused(dx10, 132, 4).what(), HasSubstr("no cube map"));
    EXPECT_THAT(refused(dx10, 140, 2).what(), HasSubstr("arrays"));
    for (std::string file : {plain, dx10}) {
        for (const std::uint32_t edge : {16u, 4096u, 65537u, 0xFFFFFFFFu}) {
            put32(file, 12, edge);
            EXPECT_NE(refused(file, 16, edge).reason(), Reason::crashed);
        }
    }
}

TEST(ImportEnvironment, BottomUpRowsAreFlipped) {
    const Cube cube = analyticCube(4);
    Cube upsideDown = cube;
    for (std::size_t row = 0; row < 24; ++row) {
        const std::size_t other = row / 4 * 4 + 3 - row % 4;
        std::copy_n(cube.texels.begin() + static_cast<std::ptrdiff_t>(4 * row), 4,
                    upsideDown.texels.begin() + static_cast<std::ptrdiff_t>(4 * other));
    }
    for (const auto& file :
         {test::ktx1File(upsideDown, KtxFormat::single3,
                         std::string("KTXorientation\0S=r,T=u", 22)),
          test::ktx2File(upsideDown, KtxFormat::single3, std::string("KTXorientation\0ru", 17))}) {
        EXPECT_EQ(decodedCube({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                              1'000'000)
                      .texels,
                  cube.texels);
    }
}

TEST(ImportEnvironment, UnsupportedFeaturesAreNamed) {
    const TemporaryFolder folder;
    const Cube cube = analyticCube(4);
    const auto refused = [&](std::string file, std::size_t at, std::uint32_t value) {
        std::memcpy(file.data() + at, &value, 4);
        return refusedMap(folder.write("map.ktx2", file));
    };
    const std::string two = text(cube, KtxFormat::half4, true);
    for (const auto& [format, name] :
         {std::pair(139u, "BC4_UNORM_BLOCK"), std::pair(157u, "ASTC_4x4_UNORM_BLOCK"),
          std::pair(9u, "R8_UNORM"), std::pair(0u, "UNDEFINED"), std::pair(77777u, "77777")}) {
        const ImportError error = refused(two, 12, format);
        EXPECT_EQ(error.reason(), Reason::unsupported);
        EXPECT_THAT(error.what(), HasSubstr(name));
    }
    EXPECT_THAT(refused(two, 44, 2).what(), HasSubstr("Zstandard"));
    EXPECT_THAT(refused(two, 36, 1).what(), HasSubstr("no cube map"));
    EXPECT_EQ(refused(two, 32, 2).reason(), Reason::unsupported) << "an array";
    EXPECT_EQ(refused(two, 24, 8).reason(), Reason::malformed) << "not square";
    const std::string one = text(cube, KtxFormat::half4, false);
    EXPECT_THAT(refused(one, 16, 0x1400).what(), HasSubstr("0x1400"));  // signed bytes
    EXPECT_THAT(refused(one, 12, 0x01020304).what(), HasSubstr("big-endian"));
    EXPECT_EQ(refusedMap(folder.write("map.png", "")).reason(), Reason::unsupported);
    EXPECT_EQ(refusedMap(folder / "none.ktx").reason(), Reason::notFound);
    EXPECT_EQ(refusedMap(folder.write("empty/readme", "").parent_path()).reason(),
              Reason::notFound);
}

TEST(ImportEnvironment, SizesAreCheckedBeforeAllocation) {
    const TemporaryFolder folder;
    for (const bool second : {false, true}) {
        std::string file = text(analyticCube(2), KtxFormat::single4, second);
        for (const std::uint32_t edge : {4096u, 65536u, 65537u, 0x40000000u, 0xFFFFFFFFu}) {
            std::memcpy(file.data() + (second ? 20 : 36), &edge, 4);
            std::memcpy(file.data() + (second ? 24 : 40), &edge, 4);
            const ImportError error = refusedMap(folder.write("large.ktx", file));
            EXPECT_TRUE(error.reason() == Reason::limit || error.reason() == Reason::malformed)
                << edge << ": " << error.what();
        }
    }
    // Half a gigabyte of pixels said in 70 bytes.
    EXPECT_EQ(refusedMap(folder.write("large.hdr",
                                      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y "
                                      "30000 +X 60000\n"))
                  .reason(),
              Reason::limit);
    std::string exr = encodeExr(panorama(8));
    const std::size_t window = exr.find("dataWindow");
    ASSERT_NE(window, std::string::npos);
    const std::int32_t box[4] = {0, 0, 59999, 29999};
    std::memcpy(exr.data() + window + 10 + 1 + 6 + 4, box, sizeof box);
    EXPECT_EQ(refusedMap(folder.write("large.exr", exr)).reason(), Reason::limit);
    for (const std::int32_t far : {2147483647, -1}) {
        const std::int32_t wild[4] = {-2147483647 - 1, 0, far, 7};
        std::memcpy(exr.data() + window + 10 + 1 + 6 + 4, wild, sizeof wild);
        refusedMap(folder.write("wild.exr", exr));
    }
}

TEST(ImportEnvironment, DamagedDdsFilesAreErrorsOrMaps) {
    std::mt19937 random(4);
    for (const std::uint32_t dxgi : {0u, 10u}) {
        const std::string file = test::ddsFile(analyticCube(8), KtxFormat::half4, dxgi, 2);
        const auto tried = [](const std::string& bytes) {
            const std::vector<unsigned char> own(bytes.begin(), bytes.end());
            try {
                decodedCube(own, 1'000'000);
                return true;
            } catch (const ImportError&) {
                return false;
            }
        };
        EXPECT_TRUE(tried(file));
        // The smaller level of the last face is not needed.
        const std::size_t needed = file.size() - 4 * 4 * 8;
        for (std::size_t length = 0; length < file.size(); ++length) {
            EXPECT_EQ(tried(file.substr(0, length)), length >= needed) << length;
        }
        for (int i = 0; i < 3000; ++i) {
            std::string damaged = file;
            for (int k = 0; k < 1 + i % 4; ++k) {
                damaged[random() % std::min<std::size_t>(i % 2 ? 152 : file.size(), file.size())] =
                    static_cast<char>(random());
            }
            tried(damaged);
        }
    }
}

TEST(ImportEnvironment, DamagedKtxFilesAreErrorsOrMaps) {
    std::mt19937 random(1);
    for (const bool second : {false, true}) {
        for (const KtxFormat format : {KtxFormat::half4, KtxFormat::bc1, KtxFormat::unorm3}) {
            const std::string file = text(analyticCube(8), format, second);
            const auto tried = [&](const std::string& bytes) {
                // A vector of its own: a read beyond the end is one beyond the allocation.
                const std::vector<unsigned char> own(bytes.begin(), bytes.end());
                try {
                    decodedCube(own, 1'000'000);
                    return true;
                } catch (const ImportError&) {
                    return false;
                }
            };
            EXPECT_TRUE(tried(file));
            for (std::size_t length = 0; length < file.size(); ++length) {
                if (second || length < 64 + 4 + 6 * 8 * 8 * 3) {
                    EXPECT_FALSE(tried(file.substr(0, length)) && length < 64) << length;
                } else {
                    tried(file.substr(0, length));
                }
            }
            for (int i = 0; i < 3000; ++i) {
                std::string damaged = file;
                for (int k = 0; k < 1 + i % 4; ++k) {
                    const std::size_t within =
                        i % 2 ? std::min<std::size_t>(128, file.size()) : file.size();
                    damaged[random() % within] = static_cast<char>(random());
                }
                tried(damaged);
            }
        }
    }
}

// tinyexr and stb may crash, hang or eat memory on these: then their process does.
TEST(ImportEnvironment, DamagedImagesAreHarmless) {
    const TemporaryFolder folder;
    std::mt19937 random(2);
    ImportOptions options;
    options.limits.addressSpaceBytes = 1ull << 30;
    options.limits.wallClock = std::chrono::seconds(10);
    const std::string exr = encodeExr(panorama(32)), hdr = hdrFile(panorama(32));
    for (int i = 0; i < 24; ++i) {
        for (const auto& [name, whole] :
             {std::pair("damaged.exr", exr), std::pair("damaged.hdr", hdr)}) {
            std::string file = whole;
            for (int k = 0; k < 1 + i % 5; ++k) {
                file[random() % std::min<std::size_t>(file.size(), 400)] =
                    static_cast<char>(random());
            }
            if (i % 3 == 0) file.resize(random() % file.size());
            try {
                loadEnvironment(folder.write(name, file), options);
            } catch (const ImportError& error) {
                EXPECT_THAT(error.what(), testing::Not(HasSubstr("/tmp")));
            }
        }
    }
}

TEST(ImportEnvironment, OutputOfTheImporterIsChecked) {
    const TemporaryFolder folder;
    const auto map = folder.write("map.ktx", text(analyticCube(2), KtxFormat::half4, false));
    const auto says = [&](const std::string& lines) {
        const auto file = folder.write("importer", "#!/bin/sh\n" + lines + "\n");
        chmod(file.c_str(), 0700);
        ImportOptions options;
        options.importer = file;
        return refusedMap(map, options).reason();
    };
    EXPECT_EQ(says("exit 0"), Reason::crashed);
    EXPECT_EQ(says("echo garbage >&3; exit 0"), Reason::crashed);
    EXPECT_EQ(says("kill -SEGV $$"), Reason::crashed);
    const std::string header = R"(printf 'CLENVMAP\001\000\000\000)";
    EXPECT_EQ(says(header + R"(\001\000\000\000' >&3; exit 0)"), Reason::crashed) << "no texels";
    EXPECT_EQ(says(header + R"(\377\377\377\377' >&3; exit 0)"), Reason::crashed) << "too large";
    EXPECT_EQ(says(header + R"(\001\000\000\000' >&3; head -c 72 /dev/zero | tr '\0' '\377' >&3)"),
              Reason::crashed)
        << "NaN";
}

}  // namespace
}  // namespace clerestory
