// Full-screen passes over a finished picture: requested filters, tone mapping, edge filter.
#include "passes/blocks.h"
#include "passes/passes.h"

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

// Draws the source of the pass into its target with parameters that were set before.
void drawFilter(PassResources& resources, const PassInput& input, const PicturePass& work,
                const char* shader, int variant = 0, const gl::State& state = {}) {
    gl::apply(state);
    gl::apply(gl::Facing{.cullBack = false});
    input.target().drawn().bind();
    input.read(work.source).texture().bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", shader, 0, variant}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const AssembleLens& work) {
    const gl::Framebuffer& frame = input.target().drawn();
    frame.bind();
    gl::clearColor({0, 0, frame.width(), frame.height()}, {0.0f, 0.0f, 0.0f, 0.0f});
    gl::apply(gl::State{.blending = work.numbers ? gl::Blending::none : gl::Blending::sum});
    gl::apply(gl::Facing{.cullBack = false});
    const int variant = work.numbers ? LENS_NUMBERS : LENS_RADIANCE;
    resources.shaders.program({"fullscreen.vert", "lens.frag", 0, variant}).use();
    resources.noVertices.bind();
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_LENS);
    auto source = work.sources.begin();
    for (const LensLookups::Part& part : resources.lensLookups.of(work)) {
        const gl::Texture& tile = input.read(*source++).texture();
        if (!part.lookups) continue;
        const auto& [x, y, width, height] = part.rect;
        blocks::FilterBlock block{};
        block.parameters = {float(x), float(y), work.depth ? 1.0f : 0.0f, 0.0f};
        setBlock(resources, block);
        tile.bind(UNIT_SOURCE);
        part.lookups->bind(UNIT_LENS);
        frame.bindPart({x, y, width, height});
        gl::drawTriangle();
    }
}

void execute(PassResources& resources, const PassInput& input, const Twirl& work) {
    setParameters(resources, work.turn, work.radius);
    drawFilter(resources, input, work, "twirl.frag");
}

void execute(PassResources& resources, const PassInput& input, const Convolve& work) {
    blocks::FilterBlock block{};
    block.parameters.x = work.repeat ? 1.0f : 0.0f;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            block.kernel[row][column] = work.kernel[static_cast<std::size_t>(3 * row + column)];
        }
    }
    setBlock(resources, block);
    drawFilter(resources, input, work, "convolve.frag");
}

void execute(PassResources& resources, const PassInput& input, const GlowBright& work) {
    setParameters(resources, work.threshold);
    drawFilter(resources, input, work, "glow_bright.frag");
}

void execute(PassResources& resources, const PassInput& input, const GlowDown& work) {
    drawFilter(resources, input, work, "glow_down.frag");
}

void execute(PassResources& resources, const PassInput& input, const GlowUp& work) {
    setParameters(resources, work.share);
    drawFilter(resources, input, work, "glow_up.frag", 0,
               {.blending = gl::Blending::premultiplied});
}

void execute(PassResources& resources, const PassInput& input, const Glow& work) {
    setParameters(resources, work.threshold, work.share);
    input.read(work.spread).texture().bind(UNIT_SPREAD);
    resources.samplers.sampler({}).bind(UNIT_SPREAD);
    drawFilter(resources, input, work, "glow.frag");
}

void execute(PassResources& resources, const PassInput& input, const BackgroundAlpha& work) {
    input.read(work.white).texture().bind(UNIT_SPREAD);
    resources.samplers.sampler({}).bind(UNIT_SPREAD);
    drawFilter(resources, input, work, "background_alpha.frag");
}

void execute(PassResources& resources, const PassInput& input, const ToneMapping& work) {
    if (input.target().spec().storage == Storage::processor) {
        const gl::Framebuffer& source = input.read(work.source).readable();
        resources.radiance.resize(std::size_t{source.width()} * source.height());
        source.readHalves(resources.radiance);
        display::toneMap({source.width(), source.height(), resources.radiance}, work.curve,
                         work.exposureFactor, work.edgeFilterFollows, input.target().picture());
        return;
    }
    setParameters(resources, work.exposureFactor, work.edgeFilterFollows ? 1.0f : 0.0f);
    const int transparent = work.transparent ? TONE_MAP_TRANSPARENT : 0;
    drawFilter(resources, input, work, "tone_map.frag", variantOf(work.curve) | transparent);
}

void execute(PassResources& resources, const PassInput& input, const EdgeFilter& work) {
    if (input.target().spec().storage == Storage::processor) {
        display::smoothEdges(input.read(work.source).picture(), work.ofSamples,
                             input.target().picture().image);
        return;
    }
    const int ofSamples = work.ofSamples ? EDGES_OF_SAMPLES : 0;
    if (work.transparent) {
        return drawFilter(resources, input, work, "edge_filter_alpha.frag", ofSamples);
    }
    const int compressed = work.compressed ? EDGES_COMPRESSED : 0;
    drawFilter(resources, input, work, "edge_filter.frag", compressed | ofSamples);
}

void execute(PassResources& resources, const PassInput& input, const StraightAlpha& work) {
    drawFilter(resources, input, work, "straight_alpha.frag");
}

}  // namespace clerestory
