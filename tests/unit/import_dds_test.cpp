// Cube maps in DDS files.
#include "environment_support.h"
#include "scene/import/textures/cube_file.h"

#include <cstring>
#include <random>

namespace clerestory {
namespace {

using testing::HasSubstr;

RadianceCube decoded(const std::string& file) {
    return decodedCube({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                       1'000'000);
}

void put32(std::string& file, std::size_t at, std::uint32_t value) {
    std::memcpy(file.data() + at, &value, 4);
}

TEST(ImportDds, CubesWithAndWithoutLevels) {
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
        loadEnvironment(folder.write("b.ktx", ktxFile(cube, KtxFormat::half4, false))).contentHash);
}

// Without a DX10 header eight bits are sRGB; the first of three or four bytes is red or blue.
TEST(ImportDds, EightBitsAreSrgbWithoutAHeader) {
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
TEST(ImportDds, BlocksAreThoseOfKtx) {
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

TEST(ImportDds, WrongFilesAreNamed) {
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
            EXPECT_NE(refused(file, 16, edge).reason(), ImportError::Reason::crashed);
        }
    }
}

TEST(ImportDds, DamagedFilesAreErrorsOrMaps) {
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

}  // namespace
}  // namespace clerestory
