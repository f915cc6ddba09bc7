// Passes over cubes. Prefiltering: level k of the target holds the radiance that a GGX lobe of
// roughness k / (levels - 1) around each direction gathers.
#include "passes/blocks.h"
#include "passes/cube_samples.h"
#include "passes/passes.h"

#include <algorithm>

namespace clerestory {
namespace {

// OpenGL 4.3, table 8.18: normal of each face, and directions of increasing s and t.
constexpr glm::vec3 kFaceAxes[6][3] = {
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
};

const gl::SamplerDescription kSmoothSource{.levels = gl::LevelFilter::linear};

void setFace(blocks::PrefilterBlock& block, std::uint32_t face, float texels) {
    for (int axis = 0; axis < 3; ++axis) {
        // w: scale from pixels of the target to 0..2, from which the shader subtracts 1.
        block.faceAxes[axis] = glm::vec4(kFaceAxes[face][axis], 2.0f / texels);
    }
}

void prefilter(PassResources& resources, const PassInput& input, const gl::Texture& source,
               std::uint32_t samplesPerTexel) {
    const TargetSpec& spec = input.target().spec();
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    source.bind(UNIT_SOURCE);
    resources.samplers.sampler(kSmoothSource).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", "environment.frag"}).use();
    resources.noVertices.bind();

    for (std::uint32_t level = 0; level < spec.levels; ++level) {
        const float roughness =
            spec.levels > 1 ? static_cast<float>(level) / static_cast<float>(spec.levels - 1) : 0;
        const float texels = static_cast<float>(std::max(1u, spec.width >> level));
        const std::vector<glm::vec4> samples = environmentSamples(
            roughness, samplesPerTexel, static_cast<float>(source.description().width), texels);
        blocks::PrefilterBlock block{};
        block.counts.x = static_cast<int>(samples.size());
        std::copy(samples.begin(), samples.end(), block.samples);
        for (std::uint32_t face = 0; face < 6; ++face) {
            setFace(block, face, texels);
            resources.prefilterBlock.assign(blocks::bytesOf(block));
            resources.prefilterBlock.bindUniform(BINDING_PREFILTER);
            input.target().face(level, face).bind();
            gl::drawTriangle();
        }
    }
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const BlurCube& work) {
    const TargetSpec& spec = input.target().spec();
    const gl::Texture& source =
        work.source == kNoTarget ? input.environment->source : input.read(work.source).texture();
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    source.bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", "map_blur.frag"}).use();
    resources.noVertices.bind();
    const std::vector<glm::vec4> rotations = blurRotations(work.blur, spec.width);
    blocks::PrefilterBlock block{};
    block.counts = {static_cast<int>(rotations.size()), static_cast<int>(work.axis), 0, 0};
    std::copy(rotations.begin(), rotations.end(), block.samples);
    for (std::uint32_t face = 0; face < 6; ++face) {
        setFace(block, face, static_cast<float>(spec.width));
        resources.prefilterBlock.assign(blocks::bytesOf(block));
        resources.prefilterBlock.bindUniform(BINDING_PREFILTER);
        input.target().face(0, face).bind();
        gl::drawTriangle();
    }
}

void execute(PassResources& resources, const PassInput& input, const PrefilterMap& work) {
    prefilter(resources, input, input.environment->source, work.samples);
}

void execute(PassResources& resources, const PassInput& input, const PrefilterCube& work) {
    prefilter(resources, input, input.read(work.source).texture(), work.samples);
}

void execute(PassResources&, const PassInput& input, const BuildLevels&) {
    input.target().makeLevels();
}

}  // namespace clerestory
