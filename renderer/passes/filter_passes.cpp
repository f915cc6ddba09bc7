// Full-screen passes over a finished picture: the tone curve, and the smoothing of edges.
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

void drawFilter(PassResources& resources, const PassInput& input, const char* shader, int variant) {
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    input.target().drawn().bind();
    input.read(0).texture().bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", shader, 0, variant}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

}  // namespace

void runToneMapPass(PassResources& resources, const PassInput& input) {
    blocks::FilterBlock block{};
    block.parameters.x = input.plan.exposureFactor;
    const auto& passes = input.plan.passes;
    const bool filtered = std::any_of(passes.begin(), passes.end(), [](const Pass& pass) {
        return pass.kind == PassKind::edgeFilter;
    });
    block.parameters.y = filtered ? 1.0f : 0.0f;
    resources.filterBlock.assign(blocks::bytesOf(block));
    resources.filterBlock.bindUniform(BINDING_FILTER);
    drawFilter(resources, input, "tone_map.frag", variantOf(input.plan.toneMap));
}

void runEdgeFilterPass(PassResources& resources, const PassInput& input) {
    drawFilter(resources, input, "edge_filter.frag", 0);
}

}  // namespace clerestory
