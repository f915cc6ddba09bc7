// Full-screen passes over a finished picture: the filters that a request asks for, the tone curve,
// and the smoothing of edges.
#include "passes/blocks.h"
#include "passes/passes.h"

#include <algorithm>

namespace clerestory {
namespace {

int variantOf(ToneMap curve) {
    switch (curve) {
        case ToneMap::neutral:
            return TONE_MAP_NEUTRAL;
        case ToneMap::aces:
            return TONE_MAP_ACES;
        case ToneMap::linear:
            return TONE_MAP_LINEAR;
    }
    return TONE_MAP_NEUTRAL;
}

void setBlock(PassResources& resources, const blocks::FilterBlock& block) {
    resources.filterBlock.assign(blocks::bytesOf(block));
    resources.filterBlock.bindUniform(BINDING_FILTER);
}

void setParameters(PassResources& resources, float x, float y = 0.0f) {
    blocks::FilterBlock block{};
    block.parameters = {x, y, 0.0f, 0.0f};
    setBlock(resources, block);
}

void drawFilter(PassResources& resources, const PassInput& input, const char* shader,
                int variant = 0, const gl::State& state = {}) {
    gl::apply(state);
    gl::apply(gl::Facing{.cullBack = false});
    input.target().drawn().bind();
    input.read(0).texture().bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", shader, 0, variant}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

}  // namespace

void runTwirlPass(PassResources& resources, const PassInput& input) {
    setParameters(resources, input.pass.filter.turn, input.pass.filter.radius);
    drawFilter(resources, input, "twirl.frag");
}

void runConvolvePass(PassResources& resources, const PassInput& input) {
    const PictureFilter& filter = input.pass.filter;
    blocks::FilterBlock block{};
    block.parameters.x = filter.repeat ? 1.0f : 0.0f;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            block.kernel[row][column] = filter.kernel[static_cast<std::size_t>(3 * row + column)];
        }
    }
    setBlock(resources, block);
    drawFilter(resources, input, "convolve.frag");
}

void runGlowBrightPass(PassResources& resources, const PassInput& input) {
    setParameters(resources, input.pass.filter.threshold);
    drawFilter(resources, input, "glow_bright.frag");
}

void runGlowDownPass(PassResources& resources, const PassInput& input) {
    drawFilter(resources, input, "glow_down.frag");
}

void runGlowUpPass(PassResources& resources, const PassInput& input) {
    setParameters(resources, input.pass.filter.share);
    drawFilter(resources, input, "glow_up.frag", 0, {.blending = gl::Blending::premultiplied});
}

void runGlowPass(PassResources& resources, const PassInput& input) {
    setParameters(resources, input.pass.filter.threshold, input.pass.filter.share);
    input.read(1).texture().bind(UNIT_SPREAD);
    resources.samplers.sampler({}).bind(UNIT_SPREAD);
    drawFilter(resources, input, "glow.frag");
}

void runToneMapPass(PassResources& resources, const PassInput& input) {
    const auto& passes = input.plan.passes;
    const bool filtered = std::any_of(passes.begin(), passes.end(), [](const Pass& pass) {
        return pass.kind == PassKind::edgeFilter;
    });
    setParameters(resources, input.plan.exposureFactor, filtered ? 1.0f : 0.0f);
    drawFilter(resources, input, "tone_map.frag", variantOf(input.plan.toneMap));
}

void runEdgeFilterPass(PassResources& resources, const PassInput& input) {
    drawFilter(resources, input, "edge_filter.frag", 0);
}

}  // namespace clerestory
