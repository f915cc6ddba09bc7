// Environment maps from every container give the same radiance in every direction; what is not
// supported is named.
#include "environment_support.h"
#include "scene/import/textures/cube_file.h"

#include <array>
#include <cstring>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using testing::HasSubstr;

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

TEST(ImportEnvironment, AllContainersGiveTheSameRadiance) {
    const TemporaryFolder folder;
    const Cube cube = analyticCube(16);
    expectAnalytic(loadEnvironment(folder.write("one.ktx", ktxFile(cube, KtxFormat::half4, false))),
                   1e-3, "KTX");
    expectAnalytic(loadEnvironment(folder.write("two.KTX2", ktxFile(cube, KtxFormat::half4, true))),
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

// Both customs of naming the faces of a folder give the same map.
TEST(ImportEnvironment, FacesHaveTwoCustomsOfNames) {
    const TemporaryFolder folder;
    const Cube cube = analyticCube(8);
    constexpr std::array kNames{std::pair{"px", "posx"}, std::pair{"nx", "negx"},
                                std::pair{"py", "posy"}, std::pair{"ny", "negy"},
                                std::pair{"pz", "posz"}, std::pair{"nz", "negz"}};
    for (std::uint32_t face = 0; face < 6; ++face) {
        const std::string file = encodeExr(linearImage(8, 8, [&](std::uint32_t x, std::uint32_t y) {
            return cube.texels[(std::size_t{face} * 8 + y) * 8 + x];
        }));
        folder.write(std::string("short/") + kNames[face].first + ".exr", file);
        folder.write(std::string("long/") + kNames[face].second + ".exr", file);
        if (face != 3) folder.write(std::string("part/") + kNames[face].second + ".exr", file);
    }
    expectAnalytic(loadEnvironment(folder / "long"), 1e-6, "posx to negz");
    EXPECT_EQ(loadEnvironment(folder / "long").contentHash,
              loadEnvironment(folder / "short").contentHash);
    EXPECT_THAT(refusedMap(folder / "part").what(), HasSubstr("no image named ny or negy"));
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
                const std::string file = ktxFile(cube, row.format, second);
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
    const std::string two = ktxFile(cube, KtxFormat::half4, true);
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
    const std::string one = ktxFile(cube, KtxFormat::half4, false);
    EXPECT_THAT(refused(one, 16, 0x1400).what(), HasSubstr("0x1400"));  // signed bytes
    EXPECT_THAT(refused(one, 12, 0x01020304).what(), HasSubstr("big-endian"));
    EXPECT_EQ(refusedMap(folder.write("map.png", "")).reason(), Reason::unsupported);
    EXPECT_EQ(refusedMap(folder / "none.ktx").reason(), Reason::notFound);
    EXPECT_EQ(refusedMap(folder.write("empty/readme", "").parent_path()).reason(),
              Reason::notFound);
}

}  // namespace
}  // namespace clerestory
