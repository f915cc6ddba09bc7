// What several kinds of pass share: the view's numbers, and the loop over draws.
#include "passes/passes.h"

#include "gl/context.h"
#include "passes/blocks.h"
#include "plan/features.h"
#include "scene/environment_brdf.h"

#include <optional>

namespace clerestory {
namespace {

// As kBrdfSize in lighting.glsl.
constexpr std::uint32_t kBrdfSize = 32;

// Enough to be worth the tiles' upkeep, few enough that filling starts soon: Sponza's court at
// 1280x720 takes 101 ms in such portions, 113 as one.
constexpr std::uint32_t kTrianglesPerSubmission = 32'000;

gl::Texture brdfTexture() {
    gl::Texture texture(
        {.format = gl::TextureFormat::rg16f, .width = kBrdfSize, .height = kBrdfSize});
    const std::vector<glm::vec2> table = environmentBrdfTable(kBrdfSize);
    texture.upload(0, 0, std::as_bytes(std::span(table)));
    return texture;
}

gl::Texture blackCube() {
    gl::Texture texture({.kind = gl::TextureKind::cube, .format = gl::TextureFormat::rgba16f});
    const glm::vec4 black(0.0f);
    for (std::uint32_t face = 0; face < 6; ++face) {
        texture.upload(0, face, std::as_bytes(std::span(&black, 1)));
    }
    return texture;
}

// Directions in eye space from the picture's centre and towards its right and top.
// x and y of clip space are w times the picture's coordinates, which gives three equations for a
// direction with w = 1. An orthographic view has one direction for the whole picture.
void setSkyDirections(const View& view, const glm::dmat3& eyeFromView, glm::vec4* directions) {
    directions[0] = directions[1] = directions[2] = glm::vec4(0.0f);
    if (view.orthographic) {
        directions[0] = glm::vec4(glm::vec3(eyeFromView * glm::dvec3(0.0, 0.0, -1.0)), 0.0f);
        return;
    }
    const glm::dmat4& clip = view.clipFromView;
    glm::dmat3 pictureFromView;  // rows x, y, w
    for (int column = 0; column < 3; ++column) {
        pictureFromView[column] = {clip[column][0], clip[column][1], clip[column][3]};
    }
    const glm::dmat3 eyeFromPicture = eyeFromView * glm::inverse(pictureFromView);
    directions[0] = glm::vec4(glm::vec3(eyeFromPicture[2]), 0.0f);
    directions[1] = glm::vec4(glm::vec3(eyeFromPicture[0]), 0.0f);
    directions[2] = glm::vec4(glm::vec3(eyeFromPicture[1]), 0.0f);
}

}  // namespace

PassResources::PassResources()
    : noVertices({}, nullptr), environmentBrdf(brdfTexture()), darkness(blackCube()) {}

void bindView(PassResources& resources, const PassInput& input, const glm::dmat3& axesFromWorld) {
    const View& view = input.pass.views.front();
    const glm::dmat3 eyeFromView =
        axesFromWorld * glm::transpose(glm::dmat3(view.viewFromWorld));  // orthogonal
    const bool clipControl = gl::Context::current().capabilities().clipControl;
    const bool lit = !input.reads.empty();

    blocks::ViewBlock block{};
    block.clipFromEye = glm::mat4(gl::deviceClip(view.clipFromView, clipControl) *
                                  glm::dmat4(glm::transpose(eyeFromView)));
    if (lit) {
        for (std::size_t i = 0; i < 9; ++i) {
            block.harmonics[i] =
                glm::vec4(input.environment->harmonics[i] * input.plan.environmentIntensity, 0.0f);
        }
    }
    const float lastLevel = lit ? static_cast<float>(input.reads.front()->spec().levels - 1) : 0.0f;
    block.environment = {lastLevel, input.plan.environmentIntensity, clipControl ? 0.0f : -1.0f,
                         0.0f};
    block.forward = glm::vec4(glm::vec3(eyeFromView * glm::dvec3(0.0, 0.0, -1.0)),
                              view.orthographic ? 1.0f : 0.0f);
    setSkyDirections(view, eyeFromView, block.skyDirections);
    resources.viewBlock.assign(blocks::bytesOf(block));
    resources.viewBlock.bindUniform(BINDING_VIEW);
}

void drawAll(PassResources& resources, const PassInput& input, std::span<const Draw> draws,
             std::uint32_t firstRecord, const DrawProgram& program) {
    const Scene& scene = input.scene->scene();
    input.scene->vertexArray().bind();
    std::optional<Features> boundFeatures;
    Index boundMaterial = kNone;
    std::optional<gl::Facing> facing;
    std::uint32_t unsubmitted = 0;  // triangles
    for (std::size_t i = 0; i < draws.size(); ++i) {
        const Draw& draw = draws[i];
        const Features features = draw.features & program.relevant;
        const Index material = scene.instances[draw.instance].material;
        if (boundFeatures != features) {
            resources.shaders.program({program.vertex, program.fragment, features, program.variant})
                .use();
            boundMaterial = kNone;  // other features read other textures
        }
        boundFeatures = features;
        if (program.materials && boundMaterial != material) {
            input.scene->bindMaterial(material, features, input.plan.anisotropy,
                                      resources.samplers);
            boundMaterial = material;
        }
        const gl::Facing wanted =
            resources.draws.facing(draw, (draw.features & FEATURE_DOUBLE_SIDED) != 0);
        if (facing != wanted) gl::apply(wanted);
        facing = wanted;
        gl::drawIndexed(draw.firstIndex, draw.indexCount,
                        firstRecord + static_cast<std::uint32_t>(i));
        ++resources.counters.drawCalls;
        resources.counters.triangles += draw.indexCount / 3;
        unsubmitted += draw.indexCount / 3;
        if (unsubmitted >= kTrianglesPerSubmission) {
            gl::submitDraws();
            unsubmitted = 0;
        }
    }
}

}  // namespace clerestory
