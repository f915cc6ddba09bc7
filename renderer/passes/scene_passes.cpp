// Passes that draw the scene from one view, and the copy of a picture as a backdrop of glass.
#include "passes/blocks.h"
#include "passes/instance_counts.h"
#include "passes/passes.h"
#include "plan/graph/features.h"
#include "plan/graph/view_bits.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr DrawProgram kDepth{"depth.vert", "depth.frag", 0, 0, false};
// Double-sided draws differ only in culling: the shader orients each normal towards the eye.
constexpr DrawProgram kSurface{"surface.vert", "surface.frag", ~FEATURE_DOUBLE_SIDED};
constexpr DrawProgram kRecording{.vertex = "surface.vert",
                                 .fragment = "surface.frag",
                                 .relevant = static_cast<Features>(~FEATURE_DOUBLE_SIDED),
                                 .recordsRays = true};

// Of the background in the alpha of a target; see distance_share.glsl.
constexpr float kFarShare = 16.0f;

const gl::SamplerDescription kSmooth{.levels = gl::LevelFilter::linear};
const gl::SamplerDescription kOneLevel{};

void bindLight(PassResources& resources, const PassInput& input, TargetId environment) {
    bindEnvironment(resources, input, environment);
    resources.environmentBrdf.bind(UNIT_ENVIRONMENT_BRDF);
    resources.samplers.sampler(kOneLevel).bind(UNIT_ENVIRONMENT_BRDF);
    resources.draws.lights().bind(UNIT_LIGHTS);
    if (input.plan.shadowMap != kNoTarget) {
        input.read(input.plan.shadowMap).texture().bind(UNIT_SHADOWS);
        resources.samplers.sampler({.compare = true}).bind(UNIT_SHADOWS);
        input.read(input.plan.shadowMap).texture().bind(UNIT_SHADOW_DEPTHS);
        resources.samplers.sampler({.magnifyLinear = false, .minifyLinear = false})
            .bind(UNIT_SHADOW_DEPTHS);
    }
    if (input.plan.shadowTints != kNoTarget) {
        input.read(input.plan.shadowTints).texture().bind(UNIT_SHADOW_TINTS);
        resources.samplers.sampler(kOneLevel).bind(UNIT_SHADOW_TINTS);
    }
    if (input.surfaceLightTexture) input.surfaceLightTexture->bind(UNIT_SURFACE_LIGHT);
}

void beginView(PassResources& resources, const PassInput& input, const PassView& view) {
    resources.draws.begin(input.scene->scene(), input.pose, view.view, input.plan.mapFromWorld,
                          input.plan.lights);
    if (input.surfaceLight) resources.draws.setSurfaceLight(*input.surfaceLight);
    if (view.environment != kNoTarget) {
        resources.draws.setHarmonics(input.environment->harmonics, input.plan.environmentIntensity);
    }
}

void bindPass(PassResources& resources, const PassInput& input, const PassView& view,
              std::uint32_t face) {
    if (input.tracer) input.tracer->addInstances(resources.draws);
    resources.draws.upload();
    bindView(resources, input, view, input.plan.mapFromWorld);
    uploadReflections(resources, input, view, input.plan.mapFromWorld);
    bindLight(resources, input, view.environment);
    if (input.tracer) input.tracer->bind(input.plan, view.view.eye, view.background);
    if (input.processorTracer) input.processorTracer->bind(view.view.eye, view.background);
    input.target().drawn(face).bind();
    gl::apply(gl::State{.colorWrite = false});
    gl::apply(gl::Facing{.cullBack = false});
    resources.noVertices.bind();
    settleSamplers(resources);
}

void drawSky(PassResources& resources, const PassInput& input) {
    gl::apply(
        gl::State{.depthTest = gl::DepthTest::equal});  // where depth is that of the far plane
    gl::apply(gl::Facing{.cullBack = false});
    input.environment->source.bind(UNIT_SOURCE);
    resources.samplers.sampler(kOneLevel).bind(UNIT_SOURCE);
    resources.shaders.program({"sky.vert", "sky.frag"}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

gl::Rect glRect(const TargetRect& rect) {
    return {rect.x, rect.y, rect.width, rect.height};
}

// Draws with the current state into the target and into the records.
void drawRecorded(PassResources& resources, const PassInput& input, const PassView& view,
                  const RecordedDraws& recorded, std::uint32_t records, std::uint32_t face) {
    if (recorded.draws.empty()) return;
    input.recording->bind();
    input.recording->clearFurther(glRect(recorded.rect));
    drawAll(resources, input, view, recorded.draws, records, kRecording);
    input.target().drawn(face).bind();
}

gl::State blendedState(const PassView& view) {
    return {.depthTest = gl::DepthTest::nearer,
            .blending = view.background.coverage ? gl::Blending::over : gl::Blending::premultiplied,
            .clip = view.view.clipPlane.has_value()};
}

void drawBlended(PassResources& resources, const PassInput& input, const PassView& view,
                 std::span<const Draw> draws, std::uint32_t records) {
    gl::apply(blendedState(view));
    drawAll(resources, input, view, draws, records, kSurface);
}

// Features that matter to the programs of channels.
constexpr Features kGeometry = FEATURE_MASK | FEATURE_DOUBLE_SIDED;
constexpr Features kCoverage = FEATURE_BASE_COLOR_MAP | FEATURE_VERTEX_COLOR |
                               FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD;

int channelVariant(Channel channel) {
    switch (channel) {
        case Channel::normal:
            return CHANNEL_NORMAL;
        case Channel::position:
            return CHANNEL_POSITION;
        case Channel::albedo:
            return CHANNEL_ALBEDO;
        case Channel::objectId:
        case Channel::instances:
        case Channel::materialId:
        case Channel::classId:
        case Channel::through:
            return CHANNEL_NUMBER;
        case Channel::flow:
            return CHANNEL_SURFACE;
        case Channel::depth:
        case Channel::color:
            break;
    }
    return CHANNEL_DEPTH;
}

DrawProgram channelProgram(const FramePlan& plan) {
    const int variant =
        plan.layer == OutputLayer::direct ? channelVariant(plan.channel) : CHANNEL_SURFACE;
    return {"surface.vert", "channel.frag", kGeometry | kCoverage, variant};
}

}  // namespace

void beginPrograms(PassResources& resources, const PassInput& input) {
    const auto begin = [&](const auto& work, const DrawProgram& program,
                           const std::vector<Draw>& draws) {
        const std::uint32_t bits = viewBits(input.plan, work.view, work.background.coverage,
                                            input.surfaceLight != nullptr);
        for (const Draw& draw : draws) {
            resources.shaders.begin(keyOf(input.plan, program, draw.features, bits));
        }
    };
    for (const Pass& pass : input.plan.passes) {
        if (const auto* scene = std::get_if<DrawScene>(&pass.work)) {
            begin(*scene, kSurface, scene->opaqueDraws);
            begin(*scene, kRecording, scene->recorded.draws);
            begin(*scene, kSurface, scene->blendedDraws);
        } else if (const auto* glass = std::get_if<DrawGlass>(&pass.work)) {
            begin(*glass, kSurface, glass->glassDraws);
            begin(*glass, kRecording, glass->recorded.draws);
            begin(*glass, kSurface, glass->blendedDraws);
        } else if (const auto* blended = std::get_if<DrawBlended>(&pass.work)) {
            begin(*blended, kSurface, blended->draws);
            begin(*blended, kRecording, blended->recorded.draws);
        }
    }
}

void execute(PassResources& resources, const PassInput& input, const DrawScene& work) {
    const PassView view{.view = work.view,
                        .reflections = work.reflections,
                        .environment = work.environment,
                        .background = work.background};
    beginView(resources, input, view);
    const std::uint32_t depthRecords = resources.draws.add(work.depthDraws);
    const std::uint32_t opaqueRecords = resources.draws.add(work.opaqueDraws);
    const std::uint32_t recordedRecords = resources.draws.add(work.recorded.draws);
    const std::uint32_t blendedRecords = resources.draws.add(work.blendedDraws);
    bindPass(resources, input, view, work.face);

    gl::State state{.depthTest = gl::DepthTest::nearer,
                    .depthWrite = true,
                    .colorWrite = false,
                    .clip = work.view.clipPlane.has_value()};
    gl::apply(state);
    const auto& radiance = work.background.radiance;
    const glm::vec4 background = radiance ? glm::vec4(*radiance, kFarShare) : glm::vec4(0.0f);
    if (input.sampled) {
        // The sky and surfaces cover everything.
        beginSampledPixels(resources, input, work.sky ? std::nullopt : std::optional(background));
    } else {
        gl::clearColorAndDepth({background.x, background.y, background.z, background.w});
    }

    const auto masked =
        std::find_if(work.opaqueDraws.begin(), work.opaqueDraws.end(),
                     [](const Draw& draw) { return (draw.features & FEATURE_MASK) != 0; });
    const std::span<const Draw> opaque(work.opaqueDraws.begin(), masked);
    const std::span<const Draw> cut(masked, work.opaqueDraws.end());

    gl::apply(state);
    // Where few pixels are shaded, the prepass costs more than what it hides.
    if (!input.sampled) {
        drawAll(resources, input, view, work.depthDraws, depthRecords, kDepth);
    }
    // Depths of the prepass are equal bit for bit; see eye_position.glsl. Without a prepass the
    // depth test is the same, because some drivers compile different code for another one.
    state.colorWrite = true;
    state.depthTest = gl::DepthTest::nearerOrEqual;
    gl::apply(state);
    drawAll(resources, input, view, opaque, opaqueRecords, kSurface);
    state.depthTest = gl::DepthTest::nearer;
    gl::apply(state);
    drawAll(resources, input, view, cut, opaqueRecords + static_cast<std::uint32_t>(opaque.size()),
            kSurface);
    state.depthTest = gl::DepthTest::nearerOrEqual;
    gl::apply(state);
    drawRecorded(resources, input, view, work.recorded, recordedRecords, work.face);
    if (work.sky) drawSky(resources, input);
    drawBlended(resources, input, view, work.blendedDraws, blendedRecords);
}

namespace {

// Binds a tile of the target and what its draws read. Returns the place of their records.
std::uint32_t beginTile(PassResources& resources, const PassInput& input, const PassView& view,
                        const gl::Rect& tile, const std::vector<Draw>& draws) {
    resources.draws.begin(input.scene->scene(), input.pose, view.view, input.plan.mapFromWorld,
                          input.plan.lights);
    const std::uint32_t records = resources.draws.add(draws);
    resources.draws.upload();
    bindView(resources, input, view, input.plan.mapFromWorld);
    input.target().drawn().bindPart(tile);
    return records;
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const DrawShadow& work) {
    constexpr DrawProgram kOpaque{.vertex = "depth.vert",
                                  .fragment = "depth.frag",
                                  .relevant = 0,
                                  .materials = false,
                                  .backFaces = true};
    constexpr DrawProgram kMasked{.vertex = "surface.vert",
                                  .fragment = "channel.frag",
                                  .relevant = kGeometry | kCoverage,
                                  .variant = CHANNEL_DEPTH,
                                  .backFaces = true};
    const PassView view{.view = work.view};
    const gl::Rect tile = glRect(work.tile);
    const std::uint32_t records = beginTile(resources, input, view, tile, work.draws);
    gl::apply(
        gl::State{.depthTest = gl::DepthTest::nearer, .depthWrite = true, .colorWrite = false});
    if (work.still == kNoTarget) {
        gl::clearDepth(tile);
    } else {
        input.target().texture().copyPart(input.read(work.still).texture(), tile);
    }
    const auto masked = std::find_if(work.draws.begin(), work.draws.end(), [](const Draw& draw) {
        return (draw.features & FEATURE_MASK) != 0;
    });
    const auto opaque = static_cast<std::size_t>(masked - work.draws.begin());
    const std::span<const Draw> draws(work.draws);
    drawAll(resources, input, view, draws.first(opaque), records, kOpaque);
    drawAll(resources, input, view, draws.subspan(opaque),
            records + static_cast<std::uint32_t>(opaque), kMasked);
}

void execute(PassResources& resources, const PassInput& input, const DrawShadowTint& work) {
    constexpr DrawProgram kTint{
        .vertex = "surface.vert",
        .fragment = "tint.frag",
        .relevant = kCoverage | FEATURE_MASK | FEATURE_BLEND | FEATURE_GLASS | FEATURE_SOLID |
                    FEATURE_TRANSMISSION_MAP | FEATURE_THICKNESS_MAP | FEATURE_DEFAULT_NUMBERS |
                    FEATURE_METALLIC_ROUGHNESS_MAP | FEATURE_PACKED_NORMAL};
    const PassView view{.view = work.view};
    const gl::Rect tile = glRect(work.tile);
    const std::uint32_t records = beginTile(resources, input, view, tile, work.draws);
    gl::apply(gl::State{.blending = gl::Blending::attenuate});
    gl::clearColor(tile, {1.0f, 1.0f, 1.0f, 0.0f});
    drawAll(resources, input, view, work.draws, records, kTint);
}

void execute(PassResources& resources, const PassInput& input, const DrawBackFaces& work) {
    constexpr DrawProgram kBackFaces{.vertex = "surface.vert",
                                     .fragment = "channel.frag",
                                     .relevant = 0,
                                     .variant = CHANNEL_BACK_FACES,
                                     .materials = false,
                                     .backFaces = true};
    const PassView view{.view = work.view};
    beginView(resources, input, view);
    const std::uint32_t records = resources.draws.add(work.draws);
    resources.draws.upload();
    bindView(resources, input, view, input.plan.mapFromWorld);
    input.target().drawn().bind();
    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer,
                        .depthWrite = true,
                        .clip = work.view.clipPlane.has_value()});
    gl::clearColorAndDepth();
    drawAll(resources, input, view, work.draws, records, kBackFaces);
}

void execute(PassResources& resources, const PassInput& input, const DrawGlass& work) {
    const PassView view{.view = work.view,
                        .reflections = work.reflections,
                        .environment = work.environment,
                        .backdrop = work.backdrop,
                        .background = work.background};
    beginView(resources, input, view);
    const std::uint32_t glassRecords = resources.draws.add(work.glassDraws);
    const std::uint32_t recordedRecords = resources.draws.add(work.recorded.draws);
    const std::uint32_t blendedRecords = resources.draws.add(work.blendedDraws);
    bindPass(resources, input, view, work.face);
    input.read(work.backdrop).texture().bind(UNIT_BACKDROP);
    resources.samplers.sampler(kSmooth).bind(UNIT_BACKDROP);
    if (work.backFaces != kNoTarget) {
        input.read(work.backFaces).texture().bind(UNIT_BACK_FACES);
        resources.samplers.sampler(kOneLevel).bind(UNIT_BACK_FACES);
    }

    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer,
                        .depthWrite = true,
                        .clip = work.view.clipPlane.has_value()});
    drawAll(resources, input, view, work.glassDraws, glassRecords, kSurface);
    drawRecorded(resources, input, view, work.recorded, recordedRecords, work.face);
    drawBlended(resources, input, view, work.blendedDraws, blendedRecords);
}

void execute(PassResources& resources, const PassInput& input, const DrawBlended& work) {
    const PassView view{.view = work.view,
                        .reflections = work.reflections,
                        .environment = work.environment,
                        .background = work.background};
    beginView(resources, input, view);
    const std::uint32_t records = resources.draws.add(work.draws);
    const std::uint32_t recordedRecords = resources.draws.add(work.recorded.draws);
    bindPass(resources, input, view, work.face);
    drawBlended(resources, input, view, work.draws, records);
    gl::apply(blendedState(view));
    drawRecorded(resources, input, view, work.recorded, recordedRecords, work.face);
}

void execute(PassResources& resources, const PassInput& input, const FollowRays& work) {
    const gl::Rect rect = glRect(work.rect);
    beginView(resources, input, {.view = work.view, .environment = work.environment});
    ProcessorTracer& tracer = *input.processorTracer;
    tracer.beginPass(
        input.plan, work, work.environment == kNoTarget ? nullptr : &input.read(work.environment),
        input.plan.shadowMap == kNoTarget ? nullptr : &input.read(input.plan.shadowMap),
        input.plan.shadowTints == kNoTarget ? nullptr : &input.read(input.plan.shadowTints),
        resources.draws, rect, input.surfaceLight, input.movingLight);
    // Rays through glass first: they bring more light than those that it mirrors, which may then be
    // coarser.
    for (std::size_t list = work.records.size() / 2; list-- > 0;) {
        resources.counters.paths += tracer.follow(list, input.read(work.records[2 * list]).drawn(),
                                                  input.read(work.records[2 * list + 1]).drawn());
    }
    const gl::Texture& radiance = input.read(work.radiance).texture();
    radiance.uploadPart(rect, std::as_bytes(tracer.radiance()));
    gl::apply(gl::State{.blending = gl::Blending::add});
    gl::apply(gl::Facing{.cullBack = false});
    input.target().drawn(work.face).bindPart(rect);
    radiance.bind(UNIT_SOURCE);
    resources.samplers.sampler({}).bind(UNIT_SOURCE);
    resources.shaders.program({"fullscreen.vert", "copy.frag"}).use();
    resources.noVertices.bind();
    gl::drawTriangle();
}

namespace {

// In the world's axes. Returns the first record of the draws.
std::uint32_t beginChannel(PassResources& resources, const PassInput& input, const PassView& view,
                           const std::vector<Draw>& draws) {
    const glm::dmat3 worldAxes(1.0);
    resources.draws.begin(input.scene->scene(), input.pose, view.view, worldAxes,
                          input.plan.lights);
    const std::uint32_t records = resources.draws.add(draws);
    resources.draws.upload();
    bindView(resources, input, view, worldAxes);
    return records;
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const DrawChannel& work) {
    const PassView view{.view = work.view};
    const std::uint32_t records = beginChannel(resources, input, view, work.draws);

    input.target().drawn().bind();
    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer, .depthWrite = true});
    gl::clearColorAndDepth();
    drawAll(resources, input, view, work.draws, records, channelProgram(input.plan));
}

void execute(PassResources& resources, const PassInput& input, const MeasureInstances& work) {
    const PassView view{.view = work.view};
    const std::uint32_t records = beginChannel(resources, input, view, work.draws);

    const gl::Framebuffer& alone = input.target().drawn();
    InstanceCounts counts(input.read(work.source).readable());
    const DrawProgram program = channelProgram(input.plan);
    for (const auto& [instance, first, count, part] : work.instances) {
        const gl::Rect rect = glRect(part);
        alone.bind();
        gl::apply(gl::State{});
        gl::clearColor(rect, {0.0f, 0.0f, 0.0f, 0.0f});
        drawAll(resources, input, view, std::span(work.draws).subspan(first, count),
                records + first, program);
        counts.add(instance, alone, rect);
    }
    resources.instances = counts.all();
}

void execute(PassResources& resources, const PassInput& input, const CopyBackdrop& work) {
    const Target& source = input.read(work.source);
    const bool isBlurred = input.target().spec().levels > 1;
    if (!input.sampled && (!isBlurred || source.spec().kind == TargetKind::cube)) {
        source.readable(work.face).copyInto(input.target().drawn());
    } else {
        gl::apply(gl::State{});
        gl::apply(gl::Facing{.cullBack = false});
        input.target().drawn().bind();
        source.texture().bind(UNIT_SOURCE);
        resources.samplers.sampler({}).bind(UNIT_SOURCE);
        if (input.sampled) bindSampledPixels(resources, input);
        resources.shaders
            .program({"fullscreen.vert", isBlurred ? "backdrop.frag" : "copy.frag", 0,
                      input.sampled ? SAMPLED_PIXELS : 0})
            .use();
        resources.noVertices.bind();
        gl::drawTriangle();
    }
    // Blurred levels of the first sample serve the others.
    if (!input.sampled) input.target().makeLevels();
}

}  // namespace clerestory
