#include "plan/effects/ray_tracing.h"

#include "plan/visibility/lighting.h"

#include <algorithm>

namespace clerestory {
namespace {

RayScene::MaterialProperties propertiesOf(const Scene& scene, const Material& material) {
    const MaterialClass c = classOf(scene, material);
    return {c.onFlat != Reflector::none, c.onCurved != Reflector::none};
}

// Relative to the instance's node, so that distance from the origin costs no precision.
std::vector<std::uint8_t> lightsOf(const Stage& stage, const Instance& instance) {
    glm::dmat4 fromNode = stage.pose.worldFromNode[instance.node];
    const glm::dvec3 origin(fromNode[3]);
    fromNode[3] = {0.0, 0.0, 0.0, 1.0};
    const Bounds& bounds = boundsOf(stage.pose, stage.scene.meshes[instance.mesh]);
    return allLightsReaching(stage.lights, origin, transformed(bounds, fromNode));
}

}  // namespace

void planRays(FramePlan& plan, const Stage& stage) {
    const bool traces = std::any_of(plan.passes.begin(), plan.passes.end(),
                                    [](const Pass& pass) { return followsRays(pass); });
    if (!traces) return;
    RayScene rays;
    rays.materialOfInstance = stage.materials.materialOfInstance;
    rays.hitFeatures = featuresOfAll(stage);
    rays.bounces = stage.settings.accuracy.bounces;
    for (const Instance& instance : stage.scene.instances) {
        rays.instances.push_back({.lights = lightsOf(stage, instance)});
    }
    for (const Surface& surface : stage.surfaces) {
        rays.instances[surface.instance].glass = surface.glass;
    }
    for (const Material& m : stage.scene.materials) {
        rays.materials.push_back(propertiesOf(stage.scene, m));
    }
    for (const Material& m : plan.materials) {
        rays.materials.push_back(propertiesOf(stage.scene, m));
    }
    plan.rays = std::move(rays);
}

}  // namespace clerestory
