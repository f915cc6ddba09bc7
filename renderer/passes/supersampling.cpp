// Further samples of chosen pixels.
#include "passes/blocks.h"
#include "passes/passes.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace clerestory {

void bindSampledPixels(PassResources& resources, const PassInput& input) {
    input.sampled->chosen.texture().bind(UNIT_SAMPLED_PIXELS);
    resources.samplers.sampler({.magnifyLinear = false, .minifyLinear = false})
        .bind(UNIT_SAMPLED_PIXELS);
}

void beginSampledPixels(PassResources& resources, const PassInput& input,
                        const std::optional<glm::vec4>& color) {
    const gl::Framebuffer& drawn = input.target().drawn();
    input.sampled->chosen.drawn().copyDepthInto(drawn);
    drawn.bind();
    if (!color) return;
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    blocks::FilterBlock block{};
    block.parameters = *color;
    resources.filterBlock.assign(blocks::bytesOf(block));
    resources.filterBlock.bindUniform(BINDING_FILTER);
    bindSampledPixels(resources, input);
    resources.shaders.program({"fullscreen.vert", "sampled_begin.frag"}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

namespace {

// Of the square that a sample represents, relative to a part of the pixel without overlaps. Places
// are not in a grid: with 1, highlights of small balls have 1.14 of their light, with 1.6 0.95.
constexpr float kEdge = 1.25f;

void upload(const PassInput& input, const Supersampling& work, Supersampler& supersampler) {
    for (const Supersampling::Part& part : work.parts) {
        const Target& chosen = input.read(part.chosen);
        const std::uint32_t width = chosen.spec().width, height = chosen.spec().height;
        chosen.texture().uploadPart({0, 0, width, height},
                                    std::as_bytes(supersampler.chosenDepths(part, width, height)));
    }
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const Supersampling& work) {
    Supersampler& supersampler = resources.supersampler;
    const Target& picture = input.target();
    supersampler.begin(work, picture);
    if (supersampler.isDone()) return;
    supersampler.add(picture);
    upload(input, work, supersampler);
    const float edge = std::min(kEdge / std::sqrt(static_cast<float>(work.samples)), 1.0f);
    for (std::uint32_t sample = 1; sample < work.samples && !supersampler.isDone(); ++sample) {
        if (sample == work.firstSamples) {
            supersampler.endAlike(work.leastDifference);
            upload(input, work, supersampler);
            if (supersampler.isDone()) break;
        }
        for (const auto& [pass, part] : work.passes) {
            if (isInterrupted(resources, input)) return;
            const auto& [origin, scale, chosen] = work.parts[part];
            input.repeater->repeat(
                pass,
                {.chosen = input.read(chosen), .place = scale * samplePlace(sample), .edge = edge});
        }
        supersampler.add(picture);
    }
    supersampler.finish(picture);
}

}  // namespace clerestory
