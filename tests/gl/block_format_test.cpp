// Compares the importer's block decoders with the driver's. Any bytes form a valid block.
#include "scene/import/textures/texel_format.h"
#include "support.h"

#include "gl/api.h"

#include <random>

using namespace clerestory;
using namespace clerestory::test;

namespace {

struct Row {
    const char* name;
    BlockFormat format;
    GLenum driver;
    double error;  // S3TC leaves the rounding of its third and fourth colour open
};
constexpr GLenum kDxt1 = 0x83F1, kDxt3 = 0x83F2, kDxt5 = 0x83F3;
const Row kRows[] = {
    {"DXT1", BlockFormat::bc1, kDxt1, 1.01 / 255},
    {"DXT3", BlockFormat::bc3, kDxt3, 1.01 / 255},
    {"DXT5", BlockFormat::bc3, kDxt5, 1.01 / 255},
    {"BC6H unsigned", BlockFormat::bc6hUnsigned, GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT, 1e-6},
    {"BC6H signed", BlockFormat::bc6hSigned, GL_COMPRESSED_RGB_BPTC_SIGNED_FLOAT, 1e-6},
    {"BC7", BlockFormat::bc7, GL_COMPRESSED_RGBA_BPTC_UNORM, 1e-6},
    {"ETC2", BlockFormat::etc2, GL_COMPRESSED_RGB8_ETC2, 1e-6},
    {"ETC2, one bit", BlockFormat::etc2Punchthrough, GL_COMPRESSED_RGB8_PUNCHTHROUGH_ALPHA1_ETC2,
     1e-6},
    {"ETC2, eight bits", BlockFormat::etc2Alpha, GL_COMPRESSED_RGBA8_ETC2_EAC, 1e-6}};

class BlockFormats : public GlTest {
protected:
    // Makes the renderer's context the current one.
    void SetUp() override { renderer().render(request(Scene{}, "empty")); }
};

}  // namespace

TEST_F(BlockFormats, MatchTheDriver) {
    constexpr std::size_t kEdge = 64;  // blocks
    constexpr std::size_t kTexels = 4 * kEdge;
    std::mt19937 random(1);
    for (const Row& row : kRows) {
        const std::size_t bytes = blockBytes(row.format);
        std::vector<unsigned char> blocks(kEdge * kEdge * bytes);
        for (unsigned char& byte : blocks) byte = static_cast<unsigned char>(random());
        GLuint texture = 0;
        glGenTextures(1, &texture);
        glActiveTexture(GL_TEXTURE0);
        glBindTexture(GL_TEXTURE_2D, texture);
        glCompressedTexImage2D(GL_TEXTURE_2D, 0, row.driver, kTexels, kTexels, 0,
                               static_cast<GLsizei>(blocks.size()), blocks.data());
        std::vector<float> rgba(4 * kTexels * kTexels);
        glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, rgba.data());
        glDeleteTextures(1, &texture);
        std::size_t wrong = 0, firstWrong = 0;
        for (std::size_t i = 0; i < kEdge * kEdge; ++i) {
            const BlockTexels texels =
                decodedBlock(row.format, std::span(blocks).subspan(i * bytes, bytes));
            for (std::size_t k = 0; k < 16; ++k) {
                const std::size_t x = 4 * (i % kEdge) + k % 4, y = 4 * (i / kEdge) + k / 4;
                const float* driver = rgba.data() + 4 * (y * kTexels + x);
                for (int c = 0; c < 3; ++c) {
                    const double scale = std::max(1.0, std::abs(double{driver[c]}));
                    const bool right = std::abs(driver[c] - texels[k][c]) <= row.error * scale;
                    if (!right && wrong++ == 0) firstWrong = i;
                }
            }
        }
        EXPECT_EQ(wrong, 0u) << row.name << ", first in the block "
                             << testing::PrintToString(std::vector<unsigned char>(
                                    blocks.begin() + std::ptrdiff_t(firstWrong * bytes),
                                    blocks.begin() + std::ptrdiff_t((firstWrong + 1) * bytes)));
    }
}
