// The scene from one view: depth first where the plan says so, opaque, masked, the sky where
// nothing was drawn, then what is seen through, far to near.
#include "passes/blocks.h"
#include "passes/passes.h"
#include "plan/features.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr DrawProgram kDepth{"depth.vert", "depth.frag", 0, 0, false};
constexpr DrawProgram kSurface{"surface.vert", "surface.frag"};

const gl::SamplerDescription kSmooth{.levels = gl::LevelFilter::linear};
const gl::SamplerDescription kOneLevel{};

void bindLight(PassResources& resources, const PassInput& input) {
    const gl::Texture& environment =
        input.reads.empty() ? resources.darkness : input.reads.front()->texture();
    environment.bind(UNIT_ENVIRONMENT);
    resources.samplers.sampler(kSmooth).bind(UNIT_ENVIRONMENT);
    resources.environmentBrdf.bind(UNIT_ENVIRONMENT_BRDF);
    resources.samplers.sampler(kOneLevel).bind(UNIT_ENVIRONMENT_BRDF);
    resources.draws.lights().bind(UNIT_LIGHTS);
}

void drawSky(PassResources& resources, const PassInput& input) {
    gl::apply(gl::State{.depthTest = gl::DepthTest::equal});  // where depth is still the far end
    gl::apply(gl::Facing{.cullBack = false});
    input.environment->source.bind(UNIT_SOURCE);
    resources.samplers.sampler(kOneLevel).bind(UNIT_SOURCE);
    resources.shaders.program({"sky.vert", "sky.frag"}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

}  // namespace

void runSurfacePass(PassResources& resources, const PassInput& input) {
    const Pass& pass = input.pass;
    resources.draws.begin(input.scene->scene(), input.pose, pass.views.front(),
                          input.plan.mapFromWorld, input.plan.lights);
    const std::uint32_t depthRecords = resources.draws.add(pass.depthDraws);
    const std::uint32_t opaqueRecords = resources.draws.add(pass.opaqueDraws);
    const std::uint32_t blendedRecords = resources.draws.add(pass.blendedDraws);
    resources.draws.upload();
    bindView(resources, input, input.plan.mapFromWorld);
    bindLight(resources, input);

    input.target.drawn().bind();
    const gl::State nearest{.depthTest = gl::DepthTest::nearer, .depthWrite = true};
    gl::apply(nearest);
    gl::clearColorAndDepth();

    const auto masked =
        std::find_if(pass.opaqueDraws.begin(), pass.opaqueDraws.end(),
                     [](const Draw& draw) { return (draw.features & FEATURE_MASK) != 0; });
    const std::span<const Draw> opaque(pass.opaqueDraws.begin(), masked);
    const std::span<const Draw> cut(masked, pass.opaqueDraws.end());

    if (!pass.depthDraws.empty()) {
        gl::apply(
            gl::State{.depthTest = gl::DepthTest::nearer, .depthWrite = true, .colorWrite = false});
        drawAll(resources, input, pass.depthDraws, depthRecords, kDepth);
        gl::apply(gl::State{.depthTest = gl::DepthTest::equal});
    }
    drawAll(resources, input, opaque, opaqueRecords, kSurface);
    gl::apply(nearest);
    drawAll(resources, input, cut, opaqueRecords + static_cast<std::uint32_t>(opaque.size()),
            kSurface);
    if (pass.sky) drawSky(resources, input);
    gl::apply(
        gl::State{.depthTest = gl::DepthTest::nearer, .blending = gl::Blending::premultiplied});
    drawAll(resources, input, pass.blendedDraws, blendedRecords, kSurface);
    input.target.resolve();
}

}  // namespace clerestory
