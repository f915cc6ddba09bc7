// Environment maps that are damaged or malicious, and an importer that is.
#include "environment_support.h"
#include "scene/import/textures/cube_file.h"

#include <sys/stat.h>

#include <cstring>
#include <random>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using testing::HasSubstr;

TEST(DamagedEnvironment, SizesAreCheckedBeforeAllocation) {
    const TemporaryFolder folder;
    for (const bool second : {false, true}) {
        std::string file = ktxFile(analyticCube(2), KtxFormat::single4, second);
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

TEST(DamagedEnvironment, DamagedKtxFilesAreErrorsOrMaps) {
    std::mt19937 random(1);
    for (const bool second : {false, true}) {
        for (const KtxFormat format : {KtxFormat::half4, KtxFormat::bc1, KtxFormat::unorm3}) {
            const std::string file = ktxFile(analyticCube(8), format, second);
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

// stb reads zeros after the end of a file.
TEST(DamagedEnvironment, ATruncatedHdrIsRefused) {
    const TemporaryFolder folder;
    const std::string whole = hdrFile(panorama(32));
    EXPECT_EQ(loadEnvironment(folder.write("whole.hdr", whole)).faceSize, 16u);
    for (const std::size_t missing :
         {std::size_t{1}, std::size_t{3}, std::size_t{4}, std::size_t{127}, std::size_t{128},
          std::size_t{1000}, whole.size() / 2}) {
        const auto file = folder.write("short.hdr", whole.substr(0, whole.size() - missing));
        EXPECT_EQ(refusedMap(file).reason(), Reason::malformed) << missing;
    }
}

// tinyexr and stb may crash, hang or eat memory on these: then their process does.
TEST(DamagedEnvironment, DamagedImagesAreHarmless) {
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

TEST(DamagedEnvironment, OutputOfTheImporterIsChecked) {
    const TemporaryFolder folder;
    const auto map = folder.write("map.ktx", ktxFile(analyticCube(2), KtxFormat::half4, false));
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
