// Scenes, frames, light and warm-up of a renderer.
#include "renderer.h"

#include "gl/buffer.h"
#include "gl/pipeline.h"
#include "passes/gpu_tracer.h"
#include "plan/effects/channels.h"
#include "plan/graph/work.h"
#include "plan/warm_up.h"
#include "renderer_state.h"
#include "scene/convexity.h"
#include "scene/default_view.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

namespace clerestory {
namespace {

using Clock = std::chrono::steady_clock;

gl::Driver driverOf(Backend backend) {
    switch (backend) {
        case Backend::automatic:
            return gl::Driver::automatic;
        case Backend::software:
            return gl::Driver::software;
        case Backend::hardware:
            return gl::Driver::hardware;
    }
    return gl::Driver::automatic;
}

bool onProcessor(Computation requested, bool software) {
    return requested == Computation::processor || (requested == Computation::automatic && software);
}

Rays raysOf(Computation requested, bool software) {
    if (onProcessor(requested, software)) return Rays::processor;
    return GpuTracer::supported() ? Rays::shader : Rays::none;
}

std::vector<LabelledInstance> labelled(const std::vector<InstanceExtent>& extents,
                                       const Scene& scene, const Pose& pose,
                                       const FrameRequest& request) {
    if (extents.empty()) return {};
    const auto materials = labelsOf(scene, Channel::materialId, request);
    const auto classes = labelsOf(scene, Channel::classId, request);
    std::vector<LabelledInstance> list;
    for (const InstanceExtent& extent : extents) {
        const Index i = extent.instance, node = scene.instances[i].node;
        list.push_back(
            {extent, scene.nodes[node].name, pose.worldFromNode[node], materials[i], classes[i]});
    }
    return list;
}

}  // namespace

Renderer::State::State(const RendererOptions& options)
    : context({.driver = driverOf(options.backend),
               .device = options.device,
               .debugOutput = options.debugOutput}),
      identity(context.capabilities()),
      limits({.maxAnisotropy = identity.maxAnisotropy,
              .software = identity.software,
              .rays = raysOf(options.rays, identity.software),
              .display = onProcessor(options.display, identity.software) ? Storage::processor
                                                                         : Storage::driver,
              .fewPrograms = options.fewPrograms && identity.software}),
      maxShadedSamples(options.maxShadedSamples),
      onReset(options.onReset),
      beforeDrawing(options.beforeDrawing),
      lights(options.light),
      compositions(
          {.upload =
               [this](const std::shared_ptr<Scene>& made, std::span<const Scene* const> sources) {
                   context.makeCurrent();
                   upload(made, sources);
               },
           .release = [this](const auto& scene) { release(scene); }}) {
    context.firstUse().whenCompiling = options.onCompiling;
}

void Renderer::State::releaseRefined(const std::vector<std::shared_ptr<const Scene>>& scenes) {
    for (const std::shared_ptr<const Scene>& fine : scenes) {
        moments.remove_if([&](const auto& m) { return m.scene == fine; });
        executor.forget(*fine);
    }
}

void Renderer::State::release(const std::shared_ptr<const Scene>& scene) {
    releaseRefined(lights.forget(*scene));
    moments.remove_if([&](const auto& m) { return m.scene == scene; });
    std::erase_if(neededLights, [&](const auto& w) { return w.subject.scene == scene; });
    executor.forget(*scene);
}

// Made for this renderer: the driver reads the memory of vertices and indices.
void Renderer::State::upload(const std::shared_ptr<Scene>& made,
                             std::span<const Scene* const> texturesOf) {
    gl::fitForSharing(made->vertices);
    gl::fitForSharing(made->indices);
    guarded([&] { executor.upload(made, texturesOf); });
}

Renderer::Renderer(const RendererOptions& options) : state_(std::make_unique<State>(options)) {}

Renderer::~Renderer() {
    state_->context.makeCurrent();
}

const RendererIdentity& Renderer::identity() const {
    return state_->identity;
}

void Renderer::addScene(Scene added) {
    removeScene(added.id);
    state_->context.makeCurrent();
    const auto scene = std::make_shared<Scene>(std::move(added));
    gl::fitForSharing(scene->vertices);
    gl::fitForSharing(scene->indices);
    try {
        // `= {}` would not free the memory.
        state_->executor.upload(scene, {}, [&](std::size_t image) {
            std::vector<std::uint8_t>().swap(scene->images[image].texels);
        });
    } catch (...) {
        state_->requireContext();
        throw;
    }
    if (state_->firstScene.empty()) state_->firstScene = scene->id;
    state_->scenes[scene->id] = {scene, ++state_->generations, isConvex(*scene, restPose(*scene))};
}

void Renderer::expectCompilation(const std::string& scene, bool expected) {
    if (expected) {
        state_->toBeCompiled.insert(scene);
    } else {
        state_->toBeCompiled.erase(scene);
    }
    state_->context.firstUse().programsAreNew = !state_->toBeCompiled.empty();
}

void Renderer::removeScene(const std::string& id) {
    expectCompilation(id, false);
    const auto found = state_->scenes.find(id);
    if (found == state_->scenes.end()) return;
    state_->context.makeCurrent();
    const std::shared_ptr<const Scene> scene = found->second.scene;
    state_->compositions.forget(scene);
    state_->release(scene);
    state_->scenes.erase(found);
}

bool Renderer::hasScene(const std::string& id) const {
    return state_->scenes.contains(id);
}

void Renderer::addEnvironment(std::shared_ptr<const EnvironmentMap> map) {
    state_->environments[map->name] = std::move(map);
}

void Renderer::removeEnvironment(const EnvironmentMap& map) {
    const auto found = state_->environments.find(map.name);
    if (found != state_->environments.end() && found->second.get() == &map) {
        state_->environments.erase(found);
    }
}

std::vector<std::string> Renderer::environmentNames() const {
    return state_->environmentNames();
}

FramePlan Renderer::plan(const FrameRequest& request) const {
    State::Subject subject = state_->subjectOf(request);
    state_->showLight(subject, request);
    state_->beginNeededLights();
    return state_->plan(subject, request);
}

Frame Renderer::State::frame(const FrameRequest& request, Readback readback,
                             const std::function<bool()>& abandoned) {
    context.makeCurrent();
    beginNeededLights();
    const light::Baker::Rest rest = lights.rest();
    Subject subject = subjectOf(request);
    const Clock::time_point start = Clock::now();
    Frame frame;
    frame.lightNow = showLight(subject, request);
    frame.sceneGeneration = subject.generation;
    frame.plan = plan(subject, request);
    frame.light = frame.plan.light.value_or(LightProgress{});
    frame.planMs = std::chrono::duration<double, std::milli>(Clock::now() - start).count();

    requireAffordable(frame.plan, maxShadedSamples);
    if (beforeDrawing) beforeDrawing(frame.plan);

    const gl::CompileCounters before = context.firstUse().counters();
    Execution execution = execute(subject, frame.plan, readback, abandoned);
    if (execution.abandoned) throw FrameAbandoned();
    const gl::CompileCounters& after = context.firstUse().counters();
    frame.compileMs = after.milliseconds - before.milliseconds;
    frame.compiled = after.programs + after.pipelines - before.programs - before.pipelines;
    frame.image = std::move(execution.image);
    frame.readbackMs = execution.readbackMilliseconds;
    frame.mapBytes = execution.mapBytes;
    for (std::size_t i = 0; i < frame.plan.passes.size(); ++i) {
        const Pass& pass = frame.plan.passes[i];
        frame.passTimes.push_back({std::string(pass.kind()), pass.name,
                                   execution.passMilliseconds[i], execution.passPaths[i]});
    }
    for (std::size_t i = 0; i < execution.health.size(); ++i) {
        const TexelCounts& counts = execution.health[i];
        if (counts.texels == 0) continue;
        frame.health.push_back(
            {frame.plan.targets[i].name, counts.texels, counts.nonFinite, counts.negative});
    }
    frame.maps = std::move(execution.maps);
    frame.instances = labelled(execution.instances, *subject.scene, *subject.pose, request);
    ++frames;
    return frame;
}

Frame Renderer::render(const FrameRequest& request, Readback readback,
                       const std::function<bool()>& abandoned) {
    return state_->frame(request, readback, abandoned);
}

void Renderer::beginNeededLights() {
    state_->context.makeCurrent();
    state_->beginNeededLights();
}

LightState Renderer::light(const FrameRequest& request) {
    state_->context.makeCurrent();
    const State::Subject subject = state_->subjectOf(request);
    const std::optional<LightInputs> inputs = state_->lightOf(subject, request);
    if (!inputs) return {};
    state_->beginLight(subject, request, *inputs);
    return state_->lights.state(inputs->hash);
}

LightState Renderer::completeLight(const FrameRequest& request,
                                   const std::function<bool()>& abandoned) {
    const LightState now = light(request);
    if (now.wait) now.wait(abandoned);
    return light(request);
}

void Renderer::forgetMaps() {
    state_->context.makeCurrent();
    state_->executor.forgetMaps();
}

struct WarmUp::Plan {
    Renderer::State::Subject subject;
    FramePlan plan;
};

std::size_t WarmUp::total() const {
    std::size_t passes = 0;
    for (const auto& plan : plans_) passes += plan->plan.passes.size();
    return passes;
}

WarmUp Renderer::beginWarmUp(const std::vector<FrameRequest>& frames) const {
    WarmUp warmUp;
    warmUp.planner_ = std::make_shared<WarmUpPlanner>();
    for (const FrameRequest& frame : frames) extend(warmUp, frame);
    return warmUp;
}

void Renderer::extend(WarmUp& warmUp, const FrameRequest& frame) const {
    State::Subject subject = state_->subjectOf(frame);
    // Frames with computed light have the same programs as those without, which come first unless
    // the light is stored on disk.
    if (const auto inputs = state_->lightOf(subject, frame)) {
        state_->findLight(subject, *inputs);
        state_->addLight(subject, frame, *inputs);
    }
    FramePlan plan = warmUp.planner_->plan(state_->plan(subject, frame));
    warmUp.plans_.push_back(
        std::make_shared<WarmUp::Plan>(WarmUp::Plan{std::move(subject), std::move(plan)}));
}

bool Renderer::advance(WarmUp& warmUp, bool fromTheEnd) {
    const std::size_t total = warmUp.total();
    if (warmUp.done_ >= total) return false;
    std::size_t step = fromTheEnd ? total - 1 - warmUp.done_ : warmUp.done_;
    ++warmUp.done_;
    auto plan = warmUp.plans_.begin();
    while (step >= (*plan)->plan.passes.size()) step -= (*plan++)->plan.passes.size();
    const State::Subject& subject = (*plan)->subject;
    const auto scene = state_->scenes.find(subject.scene->id);
    if (scene == state_->scenes.end() || scene->second.generation != subject.generation ||
        !state_->executor.holds(*subject.scene)) {
        return false;
    }
    state_->context.makeCurrent();
    state_->compile(subject, (*plan)->plan, step);
    return warmUp.done_ < total;
}

std::vector<FrameRequest> firstFramesOf(const Scene& scene) {
    FrameRequest standard;
    standard.scene = scene.id;
    FrameRequest draft = standard;
    draft.accuracy = accuracyOf(Preset::draft);
    FrameRequest distant = standard;
    const Bounds bounds = worldBounds(scene, poseAt(scene, {}, 0.0));
    if (bounds.empty()) return {standard, draft};
    const glm::dvec3 center(bounds.center());
    const double distance = 2.0 * std::max(1e-3, static_cast<double>(bounds.diagonal()));
    distant.camera.position = center + glm::dvec3(0.0, 0.3, 1.0) * distance;
    distant.camera.target = center;
    return {standard, draft, distant};
}

std::vector<FrameRequest> nearbyFramesOf(const Scene& scene) {
    // Radians about the vertical axis and upwards, and a factor of the distance.
    struct Turn {
        double aside, up, distance;
    };
    static constexpr Turn kTurns[] = {{0.0, 0.0, 1.0},  {0.15, 0.0, 1.0}, {-0.15, 0.0, 1.0},
                                      {0.4, 0.1, 1.0},  {-0.4, 0.1, 1.0}, {0.0, 0.3, 0.7},
                                      {0.0, -0.2, 1.3}, {1.0, 0.2, 1.0},  {-1.0, 0.2, 1.0},
                                      {2.2, 0.0, 1.0},  {-2.2, 0.0, 1.0}};
    const DefaultView view = defaultView(scene);
    const glm::dvec3 target(view.target), away = glm::dvec3(view.position) - target;
    const double distance = glm::length(away);
    if (!(distance > 0.0)) return {};
    const double aside = std::atan2(away.x, away.z);
    const double up = std::asin(std::clamp(away.y / distance, -1.0, 1.0));
    constexpr double kMaxElevation = 1.4;
    std::vector<FrameRequest> frames;
    for (const Turn& turn : kTurns) {
        const double a = aside + turn.aside,
                     u = std::clamp(up + turn.up, -kMaxElevation, kMaxElevation);
        const glm::dvec3 direction(std::cos(u) * std::sin(a), std::sin(u),
                                   std::cos(u) * std::cos(a));
        FrameRequest frame;
        frame.scene = scene.id;
        frame.camera.position = target + direction * (distance * turn.distance);
        frame.camera.target = target;
        frames.push_back(frame);
        frame.accuracy = accuracyOf(Preset::draft);
        frames.push_back(frame);
        for (const std::uint32_t part : {4u, 8u}) {  // in motion
            FrameRequest& small = frames.emplace_back(frame);
            small.width /= part;
            small.height /= part;
        }
    }
    return frames;
}

void endDriver() {
    gl::closeDisplays();
}

void Renderer::releaseScratch() {
    state_->context.makeCurrent();
    for (const Scene* original : state_->lights.replaced()) {
        state_->executor.forgetTables(*original);
        state_->executor.forgetMaps(*original);
    }
    const auto isShown = [this](const Scene& scene) { return state_->executor.hasShown(scene); };
    state_->lights.releaseOpen(isShown);
    state_->releaseRefined(state_->lights.releaseStored(isShown));
    state_->executor.releaseScratch();
}

void Renderer::releasePrograms() {
    state_->context.makeCurrent();
    state_->executor.releasePrograms();
}

void Renderer::releaseCompiler() {
    state_->context.makeCurrent();
    gl::releaseShaderCompiler();
}

RendererCounters Renderer::counters() const {
    const gl::ObjectCounters& made = state_->context.counters();
    const DrawCounters& drawn = state_->executor.counters();
    const gl::CompileCounters& compiled = state_->context.firstUse().counters();
    return {.frames = state_->frames,
            .drawCalls = drawn.drawCalls,
            .triangles = drawn.triangles,
            .meshesMoved = drawn.meshesMoved,
            .paths = drawn.paths,
            .lightsComputed = state_->lights.computed(),
            .texturesMade = made.textures,
            .framebuffersMade = made.framebuffers,
            .programsMade = made.programs,
            .buffersMade = made.buffers,
            .bytesShared = made.bytesShared,
            .pipelinesMade = compiled.pipelines,
            .compileMilliseconds = compiled.milliseconds};
}

std::vector<std::string> Renderer::driverMessages() const {
    return state_->context.messages();
}

}  // namespace clerestory
