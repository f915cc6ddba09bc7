// Compares the importer's block decoders with what shaders read. Any bytes form a valid block.
#include "passes/passes.h"
#include "passes/shader_library.h"
#include "passes/targets.h"
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
    double error;  // of a software driver
    // S3TC leaves the rounding of its third and fourth colour open: one step of five bits.
    double errorOfCards = error;
};
constexpr double kStep = 1.0 / 31;
constexpr GLenum kDxt1 = 0x83F1, kDxt3 = 0x83F2, kDxt5 = 0x83F3;
const Row kRows[] = {
    {"DXT1", BlockFormat::bc1, kDxt1, 1.01 / 255, kStep},
    {"DXT3", BlockFormat::bc3, kDxt3, 1.01 / 255, kStep},
    {"DXT5", BlockFormat::bc3, kDxt5, 1.01 / 255, kStep},
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

constexpr std::size_t kEdge = 64;  // blocks
constexpr std::size_t kTexels = 4 * kEdge;

// The texels of a texture. A driver's own copy may differ: glGetTexImage() of NVIDIA's
// driver 580 takes another anchor texel for partition 56 of BC7, which its shaders do not.
std::vector<float> texelsOf(GLuint texture) {
    const gl::VertexShader vertex("fullscreen.vert", shaderSource("fullscreen.vert", 0, 0));
    gl::Program program({.name = "texels", .vertex = vertex, .fragmentSource = R"(#version 430 core
layout(binding = 0) uniform sampler2D texels;
out vec4 color;
void main() { color = texelFetch(texels, ivec2(gl_FragCoord.xy), 0); }
)"});
    program.finish();
    const Target target({.name = "texels",
                         .format = Format::rgba32f,
                         .width = static_cast<std::uint32_t>(kTexels),
                         .height = static_cast<std::uint32_t>(kTexels)});
    target.drawn().bind();
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    const gl::VertexArray noVertices({}, nullptr);
    program.use();
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, texture);
    noVertices.bind();
    gl::drawTriangle();
    std::vector<float> rgba(4 * kTexels * kTexels);
    target.readable().readFloats(rgba);
    return rgba;
}

}  // namespace

TEST_F(BlockFormats, MatchTheDriver) {
    std::mt19937 random(1);
    const bool software = renderer().identity().software;
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
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
        const std::vector<float> rgba = texelsOf(texture);
        glDeleteTextures(1, &texture);
        const double error = software ? row.error : row.errorOfCards;
        std::size_t wrong = 0;
        std::string differences;
        for (std::size_t i = 0; i < kEdge * kEdge; ++i) {
            const auto block = std::span(blocks).subspan(i * bytes, bytes);
            const BlockTexels texels = decodedBlock(row.format, block);
            for (std::size_t k = 0; k < 16; ++k) {
                const std::size_t x = 4 * (i % kEdge) + k % 4, y = 4 * (i / kEdge) + k / 4;
                const float* driver = rgba.data() + 4 * (y * kTexels + x);
                for (int c = 0; c < 3; ++c) {
                    const double scale = std::max(1.0, std::abs(double{driver[c]}));
                    if (std::abs(driver[c] - texels[k][c]) <= error * scale) continue;
                    if (++wrong > 40) continue;
                    differences += "texel " + std::to_string(k) + " of " +
                                   testing::PrintToString(block) + ": " +
                                   std::to_string(driver[c]) + ", decoded " +
                                   std::to_string(texels[k][c]) + '\n';
                }
            }
        }
        EXPECT_EQ(wrong, 0u) << row.name << '\n' << differences;
    }
}
