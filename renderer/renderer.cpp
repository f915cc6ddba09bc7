#include "renderer.h"

#include "gl/buffer.h"
#include "gl/context.h"
#include "gl/pipeline.h"
#include "passes/executor.h"
#include "passes/gpu_tracer.h"
#include "plan/effects/surface_light.h"
#include "plan/graph/work.h"
#include "plan/planner.h"
#include "plan/warm_up.h"
#include "scene/convexity.h"
#include "scene_lights.h"

#include <algorithm>
#include <chrono>
#include <list>
#include <map>
#include <optional>
#include <set>

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

template <class Map>
std::string keysOf(const Map& map) {
    std::string keys;
    for (const auto& [key, value] : map) keys += (keys.empty() ? "one of: " : ", ") + key;
    return keys.empty() ? "none is loaded" : keys;
}

}  // namespace

struct Renderer::State {
    explicit State(const RendererOptions& options)
        : context({.driver = driverOf(options.backend),
                   .device = options.device,
                   .debugOutput = options.debugOutput}),
          identity(context.capabilities()),
          limits({.maxSamples = identity.maxSamples,
                  .maxAnisotropy = identity.maxAnisotropy,
                  .software = identity.software,
                  .rays = raysOf(options.rays, identity.software),
                  .maxRecordSamples = identity.maxIntegerSamples,
                  .display = onProcessor(options.display, identity.software) ? Storage::processor
                                                                             : Storage::driver}),
          maxShadedSamples(options.maxShadedSamples),
          onReset(options.onReset),
          beforeDrawing(options.beforeDrawing),
          lights(options.light) {
        context.firstUse().whenCompiling = options.onCompiling;
    }

    // The objects that a request names. subjectOf() throws InvalidRequest for unknown ones.
    struct Subject {
        std::shared_ptr<const Scene> scene;
        std::uint64_t generation;
        std::shared_ptr<const EnvironmentMap> environment;
        std::shared_ptr<const Pose> pose;
        bool convex = false;
        // With computed light of surfaces, `scene` and `pose` are those of its refined meshes.
        std::shared_ptr<const light::SurfaceLight> light = nullptr;
    };
    FrameContext contextOf(const Subject& subject, const ResidentMaps& resident) const {
        return {.scene = *subject.scene,
                .pose = *subject.pose,
                .environment = *subject.environment,
                .maps = environments,
                .resident = resident,
                .limits = limits,
                .surfaceLight = subject.light ? hashOf(*subject.light) : 0,
                .light = subject.light
                             ? LightProgress{subject.light->revision, subject.light->share}
                             : LightProgress{},
                .convex = subject.convex};
    }
    static std::uint64_t hashOf(const light::SurfaceLight& light) {
        return light.key * 0x9e3779b97f4a7c15ull + light.revision + 1;
    }
    // What the light of surfaces depends on that the request shows; nothing if it needs none.
    std::optional<LightInputs> lightOf(const Subject& subject, const FrameRequest& request) const;
    // Begins to compute it.
    void beginLight(Subject subject, const FrameRequest& request, LightInputs inputs);
    // Changes the subject to one with that light as far as it is computed, else with that of the
    // open environment.
    void addLight(Subject& subject, const FrameRequest& request, const LightInputs& inputs);
    // Both. Returns Frame::lightNow.
    std::function<LightProgress()> showLight(Subject& subject, const FrameRequest& request);
    // All views, passes and frames of one time share a pose.
    std::shared_ptr<const Pose> poseOf(const std::shared_ptr<const Scene>& scene,
                                       std::vector<Index> clips, double time) const;
    Subject subjectOf(const FrameRequest& request);
    bool hasEnvironment(const std::string& name) const;
    std::vector<std::string> environmentNames() const;  // sorted
    std::string environmentList() const;
    FramePlan plan(const Subject& subject, const FrameRequest& request) const {
        const ResidentMaps resident = executor.residentMaps();
        return planFrame(contextOf(subject, resident), request);
    }

    ExecutionInput inputOf(const Subject& subject, const FramePlan& plan) const {
        return {plan,         *subject.scene, *subject.pose, *subject.environment,
                environments, subject.light};
    }
    // These throw RenderFailed only.
    Execution execute(const Subject& subject, const FramePlan& plan, Readback readback,
                      const std::function<bool()>& abandoned) {
        Execution execution;
        guarded([&] { execution = executor.run(inputOf(subject, plan), readback, abandoned); });
        return execution;
    }
    void compile(const Subject& subject, const FramePlan& plan, std::size_t pass) {
        guarded([&] { executor.runAlone(inputOf(subject, plan), pass); });
    }
    template <class Work>
    void guarded(Work work) {
        std::optional<std::string> failure;
        try {
            work();
        } catch (const std::exception& error) {
            failure = error.what();
        }
        requireContext();
        if (!failure) return;
        executor.recover();
        throw RenderFailed(*failure);
    }
    // Throws RenderFailed when the GPU was reset.
    void requireContext() const {
        if (!context.lost()) return;
        if (onReset) onReset();
        throw RenderFailed("the GPU was reset");
    }
    Frame frame(const FrameRequest& request, Readback readback,
                const std::function<bool()>& abandoned);

    gl::Context context;  // the first member: outlives everything that holds OpenGL objects
    const RendererIdentity& identity;
    DeviceLimits limits;
    std::uint64_t maxShadedSamples;
    std::function<void()> onReset;
    std::function<void(const FramePlan&)> beforeDrawing;
    struct Loaded {
        std::shared_ptr<const Scene> scene;
        std::uint64_t generation = 0;
        bool convex = false;
    };
    std::map<std::string, Loaded> scenes;
    std::uint64_t generations = 0;  // calls of addScene()
    // Scenes as requests compose them, the one used last first. They share the textures of the
    // loaded scene.
    struct Composed {
        std::shared_ptr<const Scene> loaded, scene;
    };
    static constexpr std::size_t kMaxComposed = 4;
    static constexpr std::uint64_t kMaxComposedBytes = 1ull << 30;
    std::list<Composed> composedScenes;
    std::shared_ptr<const Scene> composedOf(const std::shared_ptr<const Scene>& loaded,
                                            const FrameRequest& request);
    void discardComposed();
    // Frees what was made for the scene.
    void release(const std::shared_ptr<const Scene>& scene);
    mutable EnvironmentMaps environments;  // built-in maps are created on first use
    std::string firstScene;                // scene of requests that name none
    Executor executor;
    std::uint64_t frames = 0;
    struct Moment {
        std::shared_ptr<const Scene> scene;
        std::vector<Index> clips;
        double time;
        std::shared_ptr<const Pose> pose;
    };
    static constexpr std::size_t kMaxMoments = 4;
    mutable std::list<Moment> moments;  // last used first
    SceneLights lights;
};

// The light between surfaces is that of materials at rest: a clip that changes them would have it
// computed again for every moment.
std::shared_ptr<const Pose> withMaterialsAtRest(const std::shared_ptr<const Pose>& pose) {
    if (pose->materials.empty()) return pose;
    Pose rest = *pose;
    rest.materials.clear();
    return std::make_shared<const Pose>(std::move(rest));
}

std::optional<LightInputs> Renderer::State::lightOf(const Subject& subject,
                                                    const FrameRequest& request) const {
    if (!showsSurfaceLight(request)) return std::nullopt;
    const ResidentMaps none;
    LightInputs inputs = lightInputs(contextOf(subject, none), request);
    if (!inputs.unneeded.empty()) return std::nullopt;
    return inputs;
}

void Renderer::State::beginLight(Subject subject, const FrameRequest& request, LightInputs inputs) {
    light::BakeInput bake{.key = inputs.hash};
    if (!lights.known(inputs.hash)) {
        const ResidentMaps none;
        subject.pose = withMaterialsAtRest(subject.pose);
        FrameContext context = contextOf(subject, none);
        context.needsRays = true;
        const FramePlan framePlan = planFrame(context, request);
        bake.pose = subject.pose;
        bake.materials = std::move(inputs.materials);
        bake.lights = std::move(inputs.lights);
        bake.environment = subject.environment;
        bake.mapFromWorld = inputs.mapFromWorld;
        bake.environmentIntensity = inputs.environmentIntensity;
        bake.emission = inputs.emission;
        guarded([&] { executor.addTables(inputOf(subject, framePlan), bake); });
    }
    lights.begin(subject.scene, std::move(bake));
}

void Renderer::State::addLight(Subject& subject, const FrameRequest& request,
                               const LightInputs& inputs) {
    std::shared_ptr<const light::SurfaceLight> light = lights.latest(inputs.hash);
    if (!light) {
        subject.light = lights.open({.scene = subject.scene,
                                     .pose = *subject.pose,
                                     .materials = inputs.materials,
                                     .environment = *subject.environment,
                                     .mapFromWorld = inputs.mapFromWorld,
                                     .environmentIntensity = inputs.environmentIntensity,
                                     .key = inputs.hash});
        return;
    }
    if (lights.mustUpload(*subject.scene, light->scene)) {
        guarded([&] { executor.upload(light->scene, subject.scene.get()); });
    }
    subject.scene = light->scene;
    subject.pose = poseOf(subject.scene, *clipsNamed(*subject.scene, request.clip), request.time);
    subject.light = std::move(light);
}

std::function<LightProgress()> Renderer::State::showLight(Subject& subject,
                                                          const FrameRequest& request) {
    const std::optional<LightInputs> inputs = lightOf(subject, request);
    if (!inputs) return {};
    beginLight(subject, request, *inputs);
    addLight(subject, request, *inputs);
    return lights.now(inputs->hash);
}

std::shared_ptr<const Pose> Renderer::State::poseOf(const std::shared_ptr<const Scene>& scene,
                                                    std::vector<Index> clips, double time) const {
    if (clips.empty()) time = 0.0;
    const auto found = std::find_if(moments.begin(), moments.end(), [&](const Moment& m) {
        return m.scene == scene && m.clips == clips && m.time == time;
    });
    if (found != moments.end()) {
        moments.splice(moments.begin(), moments, found);
    } else {
        auto pose = std::make_shared<const Pose>(poseAt(*scene, clips, time));
        moments.push_front({scene, std::move(clips), time, std::move(pose)});
        if (moments.size() > kMaxMoments) moments.pop_back();
    }
    return moments.front().pose;
}

bool Renderer::State::hasEnvironment(const std::string& name) const {
    if (environments.contains(name)) return true;
    auto map = builtinEnvironment(name);
    if (!map) return false;
    environments[name] = std::make_shared<const EnvironmentMap>(*std::move(map));
    return true;
}

std::vector<std::string> Renderer::State::environmentNames() const {
    const std::vector<std::string> builtin = builtinEnvironmentNames();
    std::set<std::string> names(builtin.begin(), builtin.end());
    for (const auto& [name, map] : environments) names.insert(name);
    return {names.begin(), names.end()};
}

std::string Renderer::State::environmentList() const {
    std::string list;
    for (const std::string& name : environmentNames()) {
        list += (list.empty() ? "one of: " : ", ") + name;
    }
    return list;
}

void Renderer::State::release(const std::shared_ptr<const Scene>& scene) {
    for (const std::shared_ptr<const Scene>& fine : lights.forget(*scene)) {
        moments.remove_if([&](const auto& m) { return m.scene == fine; });
        executor.forget(*fine);
    }
    moments.remove_if([&](const auto& m) { return m.scene == scene; });
    executor.forget(*scene);
}

void Renderer::State::discardComposed() {
    const auto bytes = [&] {
        std::uint64_t sum = 0;
        for (const Composed& c : composedScenes) {
            sum += c.scene->vertices.size() * sizeof(Vertex) +
                   c.scene->indices.size() * sizeof(std::uint32_t);
        }
        return sum;
    };
    while (composedScenes.size() > 1 &&
           (composedScenes.size() > kMaxComposed || bytes() > kMaxComposedBytes)) {
        release(composedScenes.back().scene);
        composedScenes.pop_back();
    }
}

std::shared_ptr<const Scene> Renderer::State::composedOf(const std::shared_ptr<const Scene>& loaded,
                                                         const FrameRequest& request) {
    const Composition composition{request.nodes, request.variant};
    if (composition.empty()) return loaded;
    const std::uint64_t hash = contentHash(*loaded, composition);
    const auto found = std::find_if(
        composedScenes.begin(), composedScenes.end(),
        [&](const Composed& c) { return c.loaded == loaded && c.scene->contentHash == hash; });
    if (found != composedScenes.end()) {
        composedScenes.splice(composedScenes.begin(), composedScenes, found);
        return composedScenes.front().scene;
    }
    context.makeCurrent();
    const auto scene = std::make_shared<Scene>(composed(*loaded, composition));
    gl::fitForSharing(scene->vertices);
    gl::fitForSharing(scene->indices);
    guarded([&] { executor.upload(scene, loaded.get()); });
    composedScenes.push_front({loaded, scene});
    discardComposed();
    return scene;
}

Renderer::State::Subject Renderer::State::subjectOf(const FrameRequest& request) {
    const std::string& id = request.scene.empty() ? firstScene : request.scene;
    const auto scene = scenes.find(id);
    if (scene == scenes.end()) {
        throw InvalidRequest({{"/scene", "there is no such scene", keysOf(scenes)}});
    }
    const auto& [held, generation, convex] = scene->second;
    const std::string name = request.environment.map.value_or(held->environment);
    if (!hasEnvironment(name)) {
        throw InvalidRequest(
            {{"/environment/map", "there is no such environment map", environmentList()}});
    }
    std::vector<FieldError> errors = problems(*held, request.overrides);
    for (FieldError& e : problems(*held, request.lights)) errors.push_back(std::move(e));
    for (std::size_t i = 0; i < request.overrides.size(); ++i) {
        const auto& map = request.overrides[i].environmentMap;
        if (map && !map->empty() && !hasEnvironment(*map)) {
            errors.push_back({"/overrides/" + std::to_string(i) + "/environmentMap",
                              "there is no such environment map", environmentList()});
        }
    }
    for (FieldError& e : problems(*held, request.nodes)) errors.push_back(std::move(e));
    const auto clips = clipsNamed(*held, request.clip);
    if (!clips) errors.push_back(unknownClip(*held));
    if (!hasVariant(*held, request.variant)) errors.push_back(unknownVariant(*held));
    if (!errors.empty()) throw InvalidRequest(std::move(errors));
    for (const Material& material : held->materials) hasEnvironment(material.environmentMap);
    const std::shared_ptr<const Scene> shown = composedOf(held, request);
    return {shown, generation, environments.at(name), poseOf(shown, *clips, request.time),
            convex && shown == held};
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
        state_->executor.upload(scene);
    } catch (...) {
        state_->requireContext();
        throw;
    }
    if (state_->firstScene.empty()) state_->firstScene = scene->id;
    // `= {}` would not free the memory.
    for (TextureImage& image : scene->images) std::vector<std::uint8_t>().swap(image.texels);
    state_->scenes[scene->id] = {scene, ++state_->generations, isConvex(*scene, restPose(*scene))};
}

void Renderer::removeScene(const std::string& id) {
    const auto found = state_->scenes.find(id);
    if (found == state_->scenes.end()) return;
    state_->context.makeCurrent();
    const std::shared_ptr<const Scene> scene = found->second.scene;
    for (auto c = state_->composedScenes.begin(); c != state_->composedScenes.end();) {
        if (c->loaded == scene) state_->release(c->scene);
        c = c->loaded == scene ? state_->composedScenes.erase(c) : std::next(c);
    }
    state_->release(scene);
    state_->scenes.erase(found);
}

bool Renderer::hasScene(const std::string& id) const {
    return state_->scenes.contains(id);
}

void Renderer::addEnvironment(std::shared_ptr<const EnvironmentMap> map) {
    state_->environments[map->name] = std::move(map);
}

std::vector<std::string> Renderer::environmentNames() const {
    return state_->environmentNames();
}

FramePlan Renderer::plan(const FrameRequest& request) const {
    State::Subject subject = state_->subjectOf(request);
    state_->showLight(subject, request);
    return state_->plan(subject, request);
}

Frame Renderer::State::frame(const FrameRequest& request, Readback readback,
                             const std::function<bool()>& abandoned) {
    context.makeCurrent();
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
    ++frames;
    return frame;
}

Frame Renderer::render(const FrameRequest& request, Readback readback,
                       const std::function<bool()>& abandoned) {
    return state_->frame(request, readback, abandoned);
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
    for (const FrameRequest& frame : frames) {
        State::Subject subject = state_->subjectOf(frame);
        // Frames with computed light have the same programs.
        if (const auto inputs = state_->lightOf(subject, frame)) {
            state_->addLight(subject, frame, *inputs);
        }
        FramePlan plan = warmUpPlan(state_->plan(subject, frame));
        warmUp.plans_.push_back(
            std::make_shared<WarmUp::Plan>(WarmUp::Plan{std::move(subject), std::move(plan)}));
    }
    return warmUp;
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
    if (scene == state_->scenes.end() || scene->second.generation != subject.generation) {
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

void endDriver() {
    gl::closeDisplays();
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
