#include "passes/executor.h"

#include "gl/api.h"
#include "gl/context.h"
#include "passes/ray_tables.h"

#include <algorithm>
#include <chrono>
#include <span>

namespace clerestory {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Environment maps that stay uploaded.
constexpr std::size_t kMaxMaps = 4;
// Lights of scenes that stay uploaded.
constexpr std::size_t kMaxSurfaceLights = 2;

// A driver may keep references to deleted textures: to those that its last program read until
// another one reads others in the same slots, and to the targets of pictures in its queue until
// those places of the queue are used again. llvmpipe's queue has up to 64 places, and a picture
// gets the first one that is free, so the places fill up while a larger picture is being cleared.
void dropDriverReferences(PassResources& resources) {
    constexpr int kRounds = 2, kPlaces = 64;
    constexpr std::uint32_t kLarge = 2048;
    const auto target = [](std::uint32_t edge) {
        return gl::Texture({.format = gl::TextureFormat::rgba16f, .width = edge, .height = edge});
    };
    const gl::Texture texel = target(1);
    const gl::Framebuffer small({.color = &texel, .width = 1, .height = 1});
    const auto draw = [](const gl::Framebuffer& picture) {
        picture.bind();
        gl::clearColorAndDepth();
        glFlush();
    };
    for (int round = 0; round < kRounds; ++round) {
        const gl::Texture texels = target(kLarge);
        draw(gl::Framebuffer({.color = &texels, .width = kLarge, .height = kLarge}));
        for (int place = 0; place < kPlaces; ++place) draw(small);
        resources.noVertices.bind();  // the last array may have been deleted
        settleSamplers(resources);
        glFinish();
        draw(small);  // in the place of the larger picture
        glFinish();   // the next larger one gets that place again
    }
}

// As surface_light_sampler.glsl reads them.
struct ValueWithEmitters {
    light::LightValue value;
    light::EmittersValue emitters;
};
std::vector<ValueWithEmitters> withEmitters(std::span<const light::LightValue> values,
                                            std::span<const light::EmittersValue> emitters) {
    std::vector<ValueWithEmitters> both;
    both.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) both.push_back({values[i], emitters[i]});
    return both;
}

}  // namespace

void Executor::upload(const std::shared_ptr<const Scene>& scene,
                      std::span<const Scene* const> texturesOf,
                      const std::function<void(std::size_t)>& afterImage) {
    std::vector<const GpuScene*> uploaded;
    for (const Scene* source : texturesOf) uploaded.push_back(&scenes_.at(source));
    try {
        scenes_.try_emplace(scene.get(), scene, resources_.draws.records(), uploaded, afterImage);
        gl::Context::current().throwIfFailed();
    } catch (...) {
        scenes_.erase(scene.get());
        gl::Context::current().discardErrors();
        throw;
    }
}

void Executor::recover() {
    gl::Context::current().discardErrors();
    tracers_.clear();
    processorTracers_.clear();
    flowTracers_.clear();
    maps_.clear();
    lights_.clear();
    targets_ = TargetPool();
    releasePrograms();
    resources_.samplers = SamplerCache();
    resources_.lensLookups = LensLookups();
    for (auto& [scene, uploaded] : scenes_) uploaded.forgetPose();
}

const GpuEnvironment& Executor::uploaded(const EnvironmentMap& map) {
    for (auto it = maps_.begin(); it != maps_.end(); ++it) {
        if (it->contentHash != map.contentHash) continue;
        maps_.splice(maps_.begin(), maps_, it);
        return maps_.front().environment;
    }
    maps_.push_front({map.contentHash, GpuEnvironment(map)});
    if (maps_.size() > kMaxMaps) maps_.pop_back();
    return maps_.front().environment;
}

const gl::BufferTexture& Executor::uploaded(
    const std::shared_ptr<const light::SurfaceLight>& light) {
    const auto found = std::find_if(lights_.begin(), lights_.end(),
                                    [&](const UploadedLight& u) { return u.light == light; });
    if (found != lights_.end()) {
        lights_.splice(lights_.begin(), lights_, found);
        return lights_.front().texture;
    }
    // Earlier revisions are not shown again.
    forgetOutdatedLights();
    lights_.emplace_front();
    lights_.front().light = light;
    if (light->emitters.empty()) {
        lights_.front().values.assign(std::as_bytes(std::span(light->values)));
    } else {
        const std::vector<ValueWithEmitters> all = withEmitters(light->values, light->emitters);
        lights_.front().values.assign(std::as_bytes(std::span(all)));
    }
    if (lights_.size() > kMaxSurfaceLights) lights_.pop_back();
    return lights_.front().texture;
}

// Moving instances have the light of their position.
void Executor::moveLight(const ExecutionInput& frame) {
    movingLight_.clear();
    if (!frame.surfaceLight || frame.surfaceLight->moving.empty()) return;
    movingLight_ = light::lightOfMoving(*frame.surfaceLight, frame.pose);
    uploaded(frame.surfaceLight);
    gl::Buffer& values = lights_.front().values;
    const std::span<const light::EmittersValue> emitters = frame.surfaceLight->emitters;
    if (emitters.empty()) {
        values.replace(sizeof(light::LightValue), std::as_bytes(std::span(movingLight_)));
    } else {
        const auto moving = withEmitters(movingLight_, emitters.subspan(1));
        values.replace(sizeof(ValueWithEmitters), std::as_bytes(std::span(moving)));
    }
}

void Executor::addTables(const ExecutionInput& input, light::BakeInput& bake) {
    const View view;  // rays need no positions of instances
    resources_.draws.begin(input.scene, input.pose, view, input.plan.mapFromWorld,
                           input.plan.lights);
    const std::shared_ptr<const TracedTexels> texels = scenes_.at(&input.scene).texels();
    bake.instances = instanceRows(input.scene, *input.plan.rays, resources_.draws);
    bake.materialRows = materialRows(input.scene, input.plan);
    bake.firstTextureRow = bake.materialRows.size();
    bake.materialRows.insert(bake.materialRows.end(), texels->rows.begin(), texels->rows.end());
    bake.texels = {texels, &texels->bytes};
    bake.hitFeatures = input.plan.rays->hitFeatures;
}

GpuTracer& Executor::tracerOf(const Scene& scene, const FramePlan& plan, const Pose& pose) {
    GpuTracer& tracer = tracers_.try_emplace(&scene, scenes_.at(&scene)).first->second;
    tracer.prepare(plan, pose);
    return tracer;
}

ProcessorTracer& Executor::processorTracerOf(std::map<const Scene*, ProcessorTracer>& tracers,
                                             const Scene& scene, const FramePlan& plan,
                                             const Pose& pose) {
    ProcessorTracer& tracer = tracers.try_emplace(&scene, scenes_.at(&scene)).first->second;
    tracer.prepare(plan, pose, frames_);
    return tracer;
}

void Executor::forgetTables(const Scene& scene) {
    tracers_.erase(&scene);
    processorTracers_.erase(&scene);
    flowTracers_.erase(&scene);
    std::erase_if(lights_, [&](const UploadedLight& u) { return u.light->scene.get() == &scene; });
}

void Executor::forgetOutdatedLights() {
    std::erase_if(lights_, [](const UploadedLight& u) { return u.light.use_count() == 1; });
}

void Executor::releaseScratch() {
    for (const auto& [scene, uploaded] : scenes_) {
        if (!hasShown(*scene)) forgetTables(*scene);
    }
    for (auto* tracers : {&processorTracers_, &flowTracers_}) {
        for (auto& [scene, tracer] : *tracers) tracer.releaseScratch();
    }
    forgetOutdatedLights();
    std::vector<std::uint64_t>().swap(resources_.radiance);
    resources_.supersampler = Supersampler();
    targets_.forgetTransient();
    dropDriverReferences(resources_);
}

void Executor::releasePrograms() {
    resources_.shaders = ShaderLibrary();
    gl::Context::current().firstUse().forgetPipelines();
}

void Executor::forget(const Scene& scene) {
    glFinish();  // pending work of a failed frame may still read the scene's memory
    forgetTables(scene);
    shown_.erase(&scene);
    scenes_.erase(&scene);
}

Image Executor::readBack(const FramePlan& plan, const Target& output) {
    if (output.spec().storage == Storage::processor) return std::move(output.picture().image);
    const gl::Framebuffer& source = output.readable();
    const std::uint32_t width = source.width(), height = source.height();
    if (output.spec().format == Format::srgba8) {
        // The tone mapping pass stores the top row first.
        Image image = makeImage(width, height, 4, PixelType::srgb8);
        source.readBytes(image.data);
        return image;
    }
    std::vector<float> rgba(std::size_t{4} * width * height);
    source.readFloats(rgba);
    const std::uint32_t channels = plan.transparent ? 4 : channelsOf(plan.channel);
    Image image = makeImage(width, height, channels, PixelType::float32);
    float* out = image.floats();
    for (std::uint32_t y = height; y-- > 0;) {  // OpenGL's first row is the bottom one
        const float* in = rgba.data() + std::size_t{4} * width * y;
        for (std::uint32_t x = 0; x < width; ++x, in += 4) {
            out = std::copy(in, in + image.channels, out);
        }
    }
    return image;
}

std::vector<Target*> Executor::begin(const ExecutionInput& input) {
    targets_.makeAvailable();
    resources_.instances.clear();
    if (!input.plan.materials.empty()) {
        resources_.frameMaterials.assign(input.plan.materials);
        resources_.frameMaterials.bind(0, false);  // unbinds ranges of an earlier, longer list
    }
    std::vector<Target*> targets;
    for (const TargetSpec& spec : input.plan.targets) {
        targets.push_back(&targets_.acquire(spec, input.scene));
    }
    return targets;
}

void Executor::runPass(const ExecutionInput& frame, const Pass& pass,
                       const std::vector<Target*>& targets, const std::function<bool()>& abandoned,
                       const SampledPixels* sampled) {
    const std::string_view name = pass.map();
    const auto named = frame.maps.find(std::string(name));
    const EnvironmentMap& map = named == frame.maps.end() ? frame.environment : *named->second;
    PassInput input{.plan = frame.plan,
                    .pass = pass,
                    .targets = targets,
                    .scene = &scenes_.at(&frame.scene),
                    .pose = frame.pose,
                    .flowPose = frame.flowPose,
                    .environment = name.empty() ? nullptr : &uploaded(map),
                    .surfaceLight = frame.surfaceLight.get()};
    if (frame.surfaceLight) input.surfaceLightTexture = &uploaded(frame.surfaceLight);
    input.movingLight = movingLight_;
    input.sampled = sampled;
    input.abandoned = abandoned;
    PassRepeater repeater;
    if (std::holds_alternative<Supersampling>(pass.work)) {
        repeater.repeat = [&](std::size_t again, const SampledPixels& pixels) {
            runPass(frame, frame.plan.passes[again], targets, abandoned, &pixels);
        };
        input.repeater = &repeater;
    }
    const RecordedDraws* recorded = pass.recorded();
    if (recorded && !recorded->draws.empty()) {
        std::vector<Target*> records;
        for (const TargetId id : recorded->targets) records.push_back(targets[id]);
        input.recording = &targets_.together(*targets[pass.target], pass.face(), records);
    }
    if (input.recording || std::holds_alternative<FollowRays>(pass.work) ||
        layerOf(pass) != OutputLayer::direct) {
        input.processorTracer =
            &processorTracerOf(processorTracers_, frame.scene, frame.plan, frame.pose);
        if (frame.flowPose && !haveSameShape(frame.pose, *frame.flowPose)) {
            input.flowTracer =
                &processorTracerOf(flowTracers_, frame.scene, frame.plan, *frame.flowPose);
        }
    } else if (followsRays(pass)) {
        input.tracer = &tracerOf(frame.scene, frame.plan, frame.pose);
    }
    const gl::DebugGroup group(pass.name);
    std::visit([&](const auto& work) { execute(resources_, input, work); }, pass.work);
    resources_.shaders.endPass();
    targets_.markResident(input.target());
}

void Executor::runAlone(const ExecutionInput& input, std::size_t pass) {
    const std::vector<Target*> targets = begin(input);
    resources_.counters.meshesMoved += scenes_.at(&input.scene).follow(input.pose);
    moveLight(input);
    runPass(input, input.plan.passes[pass], targets, {});
    glFinish();
    gl::Context::current().throwIfFailed();
    targets_.endFrame();
}

Execution Executor::run(const ExecutionInput& input, Readback readback,
                        const std::function<bool()>& abandoned) {
    targets_.beginFrame();
    ++frames_;
    const std::vector<Target*> targets = begin(input);
    Execution result;
    shown_.insert(&input.scene);
    resources_.counters.meshesMoved += scenes_.at(&input.scene).follow(input.pose);
    moveLight(input);
    // What the passes without a time draw into is incomplete. A map of several passes was marked
    // after the first one.
    const auto abandon = [&] {
        for (auto left = result.passPaths.size(); left < input.plan.passes.size(); ++left) {
            targets_.markIncomplete(*targets[input.plan.passes[left].target]);
        }
        gl::Context::current().throwIfFailed();
        targets_.endFrame();
        result.abandoned = true;
    };
    resources_.interrupted = false;
    for (const Pass& pass : input.plan.passes) {
        if (abandoned && abandoned()) {
            abandon();
            return result;
        }
        const Clock::time_point start = Clock::now();
        const std::uint64_t paths = resources_.counters.paths;
        runPass(input, pass, targets, abandoned);
        glFinish();  // so that the wall clock measures this pass
        if (resources_.interrupted) {
            abandon();
            return result;
        }
        result.passPaths.push_back(resources_.counters.paths - paths);
        result.passMilliseconds.push_back(millisecondsSince(start));
    }
    result.instances = std::move(resources_.instances);
    const Clock::time_point start = Clock::now();
    result.image = readBack(input.plan, *targets[input.plan.output]);
    result.readbackMilliseconds = millisecondsSince(start);
    gl::Context::current().throwIfFailed();
    for (const Target* target : targets) {
        if (target->spec().residentKey != 0) result.mapBytes += target->bytes();
    }
    if (const auto tracer = tracers_.find(&input.scene); tracer != tracers_.end()) {
        result.mapBytes += tracer->second.bytes();
    }
    for (auto* tracers : {&processorTracers_, &flowTracers_}) {
        const auto tracer = tracers->find(&input.scene);
        if (tracer != tracers->end()) result.mapBytes += tracer->second.bytes();
    }
    if (readback == Readback::health) result.health = countInvalidTexels(input.plan, targets);
    if (readback == Readback::maps) result.maps = mapPictures(input.plan, targets);
    targets_.endFrame();
    return result;
}

}  // namespace clerestory
