// The scene from one view: depth first where the plan says so, opaque, masked, the sky where
// nothing was drawn, then what is blended, far to near. And layers of glass over their backdrop.
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
    bindEnvironment(resources, input);
    resources.environmentBrdf.bind(UNIT_ENVIRONMENT_BRDF);
    resources.samplers.sampler(kOneLevel).bind(UNIT_ENVIRONMENT_BRDF);
    resources.draws.lights().bind(UNIT_LIGHTS);
}

void beginView(PassResources& resources, const PassInput& input) {
    resources.draws.begin(input.scene->scene(), input.pose, input.pass.views.front(),
                          input.plan.mapFromWorld, input.plan.lights);
    if (input.pass.environment != kNoTarget) {
        resources.draws.setHarmonics(input.environment->harmonics, input.plan.environmentIntensity);
    }
}

// Draws nothing; see settle_samplers.frag.
void settleSamplers(PassResources& resources) {
    gl::apply(gl::State{.colorWrite = false});
    gl::apply(gl::Facing{.cullBack = false});
    resources.environmentBrdf.bind(UNIT_SOURCE);
    resources.samplers.sampler(kOneLevel).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", "settle_samplers.frag"}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

void bindPass(PassResources& resources, const PassInput& input) {
    if (input.tracer) input.tracer->addPlaces(resources.draws);
    resources.draws.upload();
    bindView(resources, input, input.plan.mapFromWorld);
    uploadReflections(resources, input, input.plan.mapFromWorld);
    bindLight(resources, input);
    if (input.tracer) input.tracer->bind(input.plan, input.pass.views.front().eye);
    input.target().drawn(input.pass.face).bind();
    settleSamplers(resources);
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

void drawBlended(PassResources& resources, const PassInput& input, std::uint32_t records,
                 bool clip) {
    gl::apply(gl::State{
        .depthTest = gl::DepthTest::nearer, .blending = gl::Blending::premultiplied, .clip = clip});
    drawAll(resources, input, input.pass.blendedDraws, records, kSurface);
}

}  // namespace

void runSurfacePass(PassResources& resources, const PassInput& input) {
    const Pass& pass = input.pass;
    beginView(resources, input);
    const std::uint32_t depthRecords = resources.draws.add(pass.depthDraws);
    const std::uint32_t opaqueRecords = resources.draws.add(pass.opaqueDraws);
    const std::uint32_t blendedRecords = resources.draws.add(pass.blendedDraws);
    bindPass(resources, input);

    gl::State state{.depthTest = gl::DepthTest::nearer,
                    .depthWrite = true,
                    .colorWrite = false,
                    .clip = pass.views.front().clipPlane.has_value()};
    gl::apply(state);
    gl::clearColorAndDepth();

    const auto masked =
        std::find_if(pass.opaqueDraws.begin(), pass.opaqueDraws.end(),
                     [](const Draw& draw) { return (draw.features & FEATURE_MASK) != 0; });
    const std::span<const Draw> opaque(pass.opaqueDraws.begin(), masked);
    const std::span<const Draw> cut(masked, pass.opaqueDraws.end());

    gl::apply(state);
    drawAll(resources, input, pass.depthDraws, depthRecords, kDepth);
    // What was drawn depth first passes where it is nearest: bit for bit, see eye_position.glsl.
    // The same without a prepass, because another depth test is other code for some drivers.
    state.colorWrite = true;
    state.depthTest = gl::DepthTest::nearerOrEqual;
    gl::apply(state);
    drawAll(resources, input, opaque, opaqueRecords, kSurface);
    state.depthTest = gl::DepthTest::nearer;
    gl::apply(state);
    drawAll(resources, input, cut, opaqueRecords + static_cast<std::uint32_t>(opaque.size()),
            kSurface);
    if (pass.sky) drawSky(resources, input);
    drawBlended(resources, input, blendedRecords, state.clip);
    input.target().resolve();
}

void runBackFacesPass(PassResources& resources, const PassInput& input) {
    constexpr DrawProgram kBackFaces{.vertex = "surface.vert",
                                     .fragment = "channel.frag",
                                     .relevant = 0,
                                     .variant = CHANNEL_BACK_FACES,
                                     .materials = false,
                                     .backFaces = true};
    const Pass& pass = input.pass;
    beginView(resources, input);
    const std::uint32_t records = resources.draws.add(pass.opaqueDraws);
    resources.draws.upload();
    bindView(resources, input, input.plan.mapFromWorld);
    input.target().drawn().bind();
    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer,
                        .depthWrite = true,
                        .clip = pass.views.front().clipPlane.has_value()});
    gl::clearColorAndDepth();
    drawAll(resources, input, pass.opaqueDraws, records, kBackFaces);
}

void runGlassPass(PassResources& resources, const PassInput& input) {
    const Pass& pass = input.pass;
    beginView(resources, input);
    const std::uint32_t glassRecords = resources.draws.add(pass.opaqueDraws);
    const std::uint32_t blendedRecords = resources.draws.add(pass.blendedDraws);
    bindPass(resources, input);
    input.targets[pass.backdrop]->texture().bind(UNIT_BACKDROP);
    resources.samplers.sampler(kSmooth).bind(UNIT_BACKDROP);
    if (pass.backFaces != kNoTarget) {
        input.targets[pass.backFaces]->texture().bind(UNIT_BACK_FACES);
        resources.samplers.sampler(kOneLevel).bind(UNIT_BACK_FACES);
    }

    const bool clip = pass.views.front().clipPlane.has_value();
    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer, .depthWrite = true, .clip = clip});
    drawAll(resources, input, pass.opaqueDraws, glassRecords, kSurface);
    drawBlended(resources, input, blendedRecords, clip);
    input.target().resolve();
}

}  // namespace clerestory
