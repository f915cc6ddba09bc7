#include "plan/effects/surface_light.h"

#include "plan/request/view_settings.h"
#include "plan/visibility/lighting.h"
#include "scene/classification.h"
#include "scene/hash.h"

#include <algorithm>

namespace clerestory {
namespace {

bool emits(const Material& m) {
    const glm::vec3 radiance = emittedRadiance(m);
    return !m.unlit && std::max({radiance.r, radiance.g, radiance.b}) > 0.0f;
}

// Calls `is` with the materials of all surfaces until one fulfils it.
template <class Is>
bool anyMaterial(const Scene& scene, const MaterialBindings& materials, Is is) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (scene.meshes[scene.instances[i].mesh].primitive != Primitive::triangles) continue;
        if (is(materials.material(scene, materials.materialOf(scene, static_cast<Index>(i))))) {
            return true;
        }
    }
    return false;
}

std::string reasonWithout(const FrameContext& context, const LightInputs& inputs) {
    if (context.convex) return "no surface faces another";
    if (!anyMaterial(context.scene, inputs.materials, [](const Material& m) { return !m.unlit; })) {
        return "no surface is lit";
    }
    const bool sky = inputs.environmentIntensity * context.environment.meanRadiance > 0.0f;
    if (!sky && !inputs.emitters && inputs.lights.empty()) return "there is no light source";
    return {};
}

void setStillLights(const FrameContext& context, const FrameRequest& request,
                    const ViewSettings& settings, LightInputs& inputs) {
    std::vector<Light> lights = lightsWith(context.scene.lights, request.lights);
    const std::vector<bool> moves = nodesThatMove(context.scene);
    const std::size_t all = lights.size();
    std::erase_if(lights,
                  [&](const Light& light) { return light.node != kNone && moves[light.node]; });
    inputs.movingLights = all - lights.size();
    inputs.lights =
        placedLights(lights, context.pose, context.environment,
                     glm::transpose(settings.mapFromWorld), settings.environmentIntensity);
}

}  // namespace

// Of materials and lights as they are at rest: a clip that changes them would begin another
// computation for every moment.
LightInputs lightInputs(const FrameContext& context, const FrameRequest& request) {
    if (std::vector<FieldError> errors = problems(request); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    const ViewSettings settings =
        viewSettings(request, context.scene, context.limits.maxAnisotropy);
    Pose rest = context.pose;
    rest.materials.clear();
    LightInputs inputs{
        .materials = bindMaterials(context.scene, rest, request.overrides, request.variant),
        .mapFromWorld = settings.mapFromWorld,
        .environmentIntensity = settings.environmentIntensity,
        .emission = settings.effects.emission};
    inputs.emitters = inputs.emission && anyMaterial(context.scene, inputs.materials, emits);
    setStillLights(context, request, settings, inputs);
    ContentHash hash;
    hash.add(context.scene.contentHash);
    hash.add(context.environment.contentHash);
    for (const PlacedLight& light : inputs.lights) {
        hash.add(light.kind);
        hash.add(light.position);
        hash.add(light.toLight);
        hash.add(light.intensity);
        hash.add(light.range);
        hash.add(light.cosInner);
        hash.add(light.cosOuter);
        hash.add(light.radius);
    }
    for (const Material& material : inputs.materials.own) hash.add(contentHash(material));
    for (const Index index : inputs.materials.materialOfInstance) hash.add(index);
    hash.add(inputs.mapFromWorld);
    hash.add(inputs.environmentIntensity);
    hash.add(inputs.emission);
    inputs.hash = hash.value();
    inputs.unneeded = reasonWithout(context, inputs);
    return inputs;
}

void planSurfaceLight(FramePlan& plan, const FrameContext& context, const FrameRequest& request) {
    if (!showsSurfaceLight(request)) return;
    const LightInputs inputs = lightInputs(context, request);
    const auto skip = [&](std::string reason) {
        plan.skipped.push_back({"lightBetweenSurfaces", Effect::indirectLight, std::move(reason)});
    };
    if (!inputs.unneeded.empty()) {
        plan.light = LightProgress{.revision = 0, .share = 1.0};
        return skip(inputs.unneeded);
    }
    plan.surfaceLight = context.surfaceLight;
    plan.emitters = inputs.emitters;
    plan.light = context.light;
    if (inputs.movingLights > 0) {
        skip(std::to_string(inputs.movingLights) +
             (inputs.movingLights == 1 ? " light moves" : " lights move") +
             ": light of moving lights is not reflected between surfaces");
    }
}

}  // namespace clerestory
