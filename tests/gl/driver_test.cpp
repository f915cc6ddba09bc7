// Verifies the code's assumptions about OpenGL with the driver.
#include "support.h"

#include "gl/api.h"
#include "gl/context.h"
#include "gl/pipeline.h"
#include "passes/blocks.h"
#include "passes/gpu_environment.h"
#include "passes/shader_library.h"
#include "plan/effects/ray_tracing.h"
#include "plan/graph/features.h"

#include <set>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Driver : public GlTest {
protected:
    // Makes the renderer's context the current one.
    void SetUp() override { renderer().render(request(Scene{}, "empty")); }
};

std::set<std::string> activeNames(GLuint program, GLenum interface) {
    GLint count = 0;
    glGetProgramInterfaceiv(program, interface, GL_ACTIVE_RESOURCES, &count);
    std::set<std::string> names;
    for (GLint i = 0; i < count; ++i) {
        char name[128] = {};
        glGetProgramResourceName(program, interface, static_cast<GLuint>(i), sizeof name, nullptr,
                                 name);
        names.insert(name);
    }
    return names;
}

std::set<std::string> samplersOf(const gl::Program& program) {
    std::set<std::string> samplers;
    for (const std::string& name : activeNames(program.name(), GL_UNIFORM)) {
        const bool ofBlock = name.find('.') != std::string::npos;
        const bool ofDriver = name.starts_with("gl_");
        if (!ofBlock && !ofDriver) samplers.insert(name);
    }
    return samplers;
}

GLint offsetOf(const gl::Program& program, const char* member) {
    const GLuint index = glGetProgramResourceIndex(program.name(), GL_UNIFORM, member);
    if (index == GL_INVALID_INDEX) return -1;
    const GLenum property = GL_OFFSET;
    GLint offset = -1;
    glGetProgramResourceiv(program.name(), GL_UNIFORM, index, 1, &property, 1, nullptr, &offset);
    return offset;
}

}  // namespace

TEST_F(Driver, UniformBlockLayoutMatchesCpp) {
    ShaderLibrary library;
    const auto& surface = library.program(
        {"surface.vert", "surface.frag", FEATURE_BASE_COLOR_MAP | FEATURE_TEXTURE_TRANSFORM});
    using blocks::MaterialBlock, blocks::PrefilterBlock, blocks::ViewBlock;
    EXPECT_EQ(offsetOf(surface, "ViewBlock.clipFromEye"), offsetof(ViewBlock, clipFromEye));
    EXPECT_EQ(offsetOf(surface, "ViewBlock.environment"), offsetof(ViewBlock, environment));
    EXPECT_EQ(offsetOf(surface, "ViewBlock.forward"), offsetof(ViewBlock, forward));
    EXPECT_EQ(offsetOf(surface, "ViewBlock.skyDirections[0]"), offsetof(ViewBlock, skyDirections));
    EXPECT_EQ(offsetOf(surface, "MaterialBlock.baseColor"), offsetof(MaterialBlock, baseColor));
    EXPECT_EQ(offsetOf(surface, "MaterialBlock.surface"), offsetof(MaterialBlock, surface));
    EXPECT_EQ(offsetOf(surface, "MaterialBlock.emissive"), offsetof(MaterialBlock, emissive));
    EXPECT_EQ(offsetOf(surface, "MaterialBlock.dielectricF0"),
              offsetof(MaterialBlock, dielectricF0));
    EXPECT_EQ(offsetOf(surface, "MaterialBlock.texCoordRows[0]"),
              offsetof(MaterialBlock, texCoordRows));
    const auto& environment = library.program({"fullscreen.vert", "environment.frag"});
    EXPECT_EQ(offsetOf(environment, "PrefilterBlock.counts"), offsetof(PrefilterBlock, counts));
    EXPECT_EQ(offsetOf(environment, "PrefilterBlock.samples[0]"),
              offsetof(PrefilterBlock, samples));
}

TEST_F(Driver, VariantsContainOnlyTheirFeatures) {
    ShaderLibrary library;
    const auto samplers = [&](Features features) {
        return samplersOf(library.program({"surface.vert", "surface.frag", features}));
    };
    using Names = std::set<std::string>;
    EXPECT_EQ(samplers(FEATURE_UNLIT), Names{});
    EXPECT_EQ(samplers(FEATURE_UNLIT | FEATURE_BASE_COLOR_MAP), Names{"baseColorMap"});
    const Names lit{"environmentMap", "environmentBrdf", "lightTable"};
    EXPECT_EQ(samplers(0), lit);
    EXPECT_EQ(samplers(FEATURE_LIGHTS), lit);
    EXPECT_EQ(samplers(FEATURE_NORMAL_MAP),
              (Names{"environmentMap", "environmentBrdf", "lightTable", "normalMap"}));
    EXPECT_EQ(samplers(FEATURE_EMISSION), lit);
    const auto& depth = library.program({"depth.vert", "depth.frag"});
    EXPECT_EQ(activeNames(depth.name(), GL_PROGRAM_INPUT), (Names{"position", "eyeFromModel[0]"}));
}

TEST_F(Driver, EveryFeatureCompilesAlone) {
    ShaderLibrary library;
    for (int bit = 0; bit < 14; ++bit) {
        EXPECT_NO_THROW(library.program({"surface.vert", "surface.frag", 1u << bit})) << bit;
    }
    const Features every = withoutExcessMaps(~FEATURE_UNLIT);
    const auto& all = library.program({"surface.vert", "surface.frag", every});
    EXPECT_LE(samplersOf(all).size(), 32u);  // what drivers of graphics cards allow
}

TEST_F(Driver, CompilationErrorsNameTheShader) {
    const Renderer silent({});  // its context is current now and collects no messages
    try {
        const gl::VertexShader vertex("sound", "#version 430\nvoid main() {}");
        gl::Program(
            {.name = "broken", .vertex = vertex, .fragmentSource = "#version 430\nnonsense"})
            .finish();
        FAIL();
    } catch (const std::runtime_error& e) {
        EXPECT_NE(std::string(e.what()).find("broken"), std::string::npos);
    }
}

TEST_F(Driver, DepthRangeMatchesTheDevice) {
    glm::dmat4 clip(0.0);  // reversed, infinite, near at 0.5
    clip[0][0] = clip[1][1] = 1.0;
    clip[2][3] = -1.0;
    clip[3][2] = 0.5;
    const auto depthAt = [&](double distance, bool clipControl) {
        const glm::dvec4 p = gl::deviceClip(clip, clipControl) * glm::dvec4(0, 0, -distance, 1);
        return p.z / p.w;
    };
    EXPECT_DOUBLE_EQ(depthAt(0.5, true), 1.0);
    EXPECT_NEAR(depthAt(1e12, true), 0.0, 1e-12);
    // Without clip control -1..1, which OpenGL maps to 0..1.
    EXPECT_DOUBLE_EQ(depthAt(0.5, false), 1.0);
    EXPECT_NEAR(depthAt(1e12, false), -1.0, 1e-11);
    EXPECT_DOUBLE_EQ(0.5 + 0.5 * depthAt(2.0, false), depthAt(2.0, true));
}

TEST_F(Driver, TheRequestedDriverIsUsed) {
    const RendererIdentity& identity = renderer().identity();
    EXPECT_FALSE(identity.renderer.empty());
    EXPECT_FALSE(identity.platform.empty());
    EXPECT_GE(identity.maxTextureSize, 16384u);
    if (identity.software) {
        EXPECT_FALSE(identity.timerQueriesTrusted);
        EXPECT_THROW(Renderer({.backend = Backend::hardware}), std::runtime_error);
    }
}

TEST_F(Driver, TwoRenderersCoexist) {
    if (!renderer().identity().software) GTEST_SKIP() << "compares bytes of one software driver";
    const FrameRequest r = request(Scene{}, "empty");
    const Image first = renderer().render(r).image;
    {
        Renderer other({.backend = Backend::software, .debugOutput = true});
        Scene scene;
        scene.id = "empty";
        scene.environment = "black";
        other.addScene(scene);
        EXPECT_EQ(other.render(r).image.data, first.data);
        EXPECT_EQ(other.driverMessages(), std::vector<std::string>{});
    }
    EXPECT_EQ(renderer().render(r).image.data, first.data);
}

TEST(HalvedFace, IsTheMeanOfFourTexelsAndKeepsOddEdges) {
    const std::vector<glm::vec3> four = {glm::vec3(1), glm::vec3(2), glm::vec3(3), glm::vec3(6)};
    EXPECT_EQ(halvedFace(four, 2), std::vector<glm::vec3>{glm::vec3(3)});
    EXPECT_EQ(halvedFace(std::vector<glm::vec3>(25, glm::vec3(0.5f)), 5),
              std::vector<glm::vec3>(4, glm::vec3(0.5f)));
}
