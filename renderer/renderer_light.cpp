// The light between surfaces: what a request needs of it, and the scene that shows it.
#include "renderer_state.h"

#include <algorithm>
#include <utility>

namespace clerestory {
namespace {

// The light between surfaces is that of materials at rest: a clip that changes them would have it
// computed again for every moment.
std::shared_ptr<const Pose> withMaterialsAtRest(const std::shared_ptr<const Pose>& pose) {
    if (pose->materials.empty()) return pose;
    Pose rest = *pose;
    rest.materials.clear();
    return std::make_shared<const Pose>(std::move(rest));
}

}  // namespace

std::optional<LightInputs> Renderer::State::lightOf(const Subject& subject,
                                                    const FrameRequest& request) const {
    if (!showsSurfaceLight(request)) return std::nullopt;
    const ResidentMaps none;
    LightInputs inputs = lightInputs(contextOf(subject, none), request);
    if (!inputs.unneeded.empty()) return std::nullopt;
    return inputs;
}

bool Renderer::State::findLight(const Subject& subject, const LightInputs& inputs) {
    return lights.known(inputs.hash) ||
           lights.find(*subject.scene, *withMaterialsAtRest(subject.pose), inputs.hash);
}

void Renderer::State::beginLight(Subject subject, const FrameRequest& request, LightInputs inputs) {
    if (findLight(subject, inputs)) return;
    const ResidentMaps none;
    subject.pose = withMaterialsAtRest(subject.pose);
    FrameContext context = contextOf(subject, none);
    context.needsRays = true;
    const FramePlan framePlan = planFrame(context, request);
    light::BakeInput bake{.key = inputs.hash};
    bake.pose = subject.pose;
    bake.materials = std::move(inputs.materials);
    bake.lights = std::move(inputs.lights);
    bake.environment = subject.environment;
    bake.mapFromWorld = inputs.mapFromWorld;
    bake.environmentIntensity = inputs.environmentIntensity;
    bake.emission = inputs.emission;
    bake.emitters = inputs.emitters;
    guarded([&] { executor.addTables(inputOf(subject, framePlan), bake); });
    lights.begin(subject.scene, std::move(bake));
}

void Renderer::State::addLight(Subject& subject, const FrameRequest& request,
                               const LightInputs& inputs) {
    subject.lightFailed = !lights.state(inputs.hash).failure.empty();
    std::shared_ptr<const light::SurfaceLight> light = lights.latest(inputs.hash);
    if (!light) {
        subject.light = lights.open({.scene = subject.scene,
                                     .pose = *subject.pose,
                                     .materials = inputs.materials,
                                     .environment = *subject.environment,
                                     .mapFromWorld = inputs.mapFromWorld,
                                     .environmentIntensity = inputs.environmentIntensity,
                                     .emitters = inputs.emitters,
                                     .key = inputs.hash});
        return;
    }
    lights.addShown(*subject.scene, light->scene);
    if (!executor.holds(*light->scene)) {
        const Scene* const original[] = {subject.scene.get()};
        guarded([&] { executor.upload(light->scene, original); });
    }
    subject.scene = light->scene;
    subject.pose = poseOf(subject.scene, *clipsNamed(*subject.scene, request.clip), request.time);
    subject.light = std::move(light);
}

std::function<LightProgress()> Renderer::State::showLight(Subject& subject,
                                                          const FrameRequest& request) {
    const std::optional<LightInputs> inputs = lightOf(subject, request);
    if (!inputs) return {};
    const bool isNoted = std::any_of(neededLights.begin(), neededLights.end(),
                                     [&](const auto& w) { return w.inputs.hash == inputs->hash; });
    if (!isNoted && !findLight(subject, *inputs)) {
        neededLights.push_back({subject, request, *inputs});
    }
    addLight(subject, request, *inputs);
    return lights.now(inputs->hash);
}

void Renderer::State::beginNeededLights() {
    for (NeededLight& needed : std::exchange(neededLights, {})) {
        beginLight(std::move(needed.subject), needed.request, std::move(needed.inputs));
    }
}

}  // namespace clerestory
