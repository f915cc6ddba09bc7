// What a map's pixels depend on.
#include "plan/plan_hash.h"

namespace clerestory {
namespace {

void addView(PlanHash& hash, const View& view) {
    hash.add(view.viewFromWorld);
    hash.add(view.clipFromView);
    hash.add(view.eye);
    hash.add(view.clipPlane.value_or(glm::dvec4(0.0)));
}

void addLight(PlanHash& hash, const PlacedLight& light) {
    hash.add(light.kind);
    hash.add(light.position);
    hash.add(light.toLight);
    hash.add(light.intensity);
    hash.add(light.range);
    hash.add(light.cosInner);
    hash.add(light.cosOuter);
}

void addDraws(PlanHash& hash, const std::vector<Draw>& draws, const Stage& stage) {
    hash.add(draws.size());
    for (const Draw& draw : draws) {
        const Instance& instance = stage.scene.instances[draw.instance];
        hash.add(draw.instance);
        hash.add(draw.material);
        hash.add(draw.firstIndex);
        hash.add(draw.indexCount);
        hash.add(draw.features);
        hash.add(draw.reflection);
        hash.add(stage.pose.worldFromNode[instance.node]);
        if (const auto* mesh = deformedMesh(stage.pose, stage.scene.meshes[instance.mesh])) {
            hash.add(mesh->hash);
        }
        hash.add(draw.lights.count);
        for (std::uint32_t i = 0; i < draw.lights.count; ++i) {
            addLight(hash, stage.lights[draw.lights.indices[i]]);
        }
    }
}

// For rays, which meet whatever there is.
void addEverything(PlanHash& hash, const Stage& stage) {
    for (const glm::dmat4& m : stage.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage.pose.deformed) hash.add(deformed->hash);
    for (const PlacedLight& light : stage.lights) addLight(hash, light);
}

void addTarget(PlanHash& hash, const TargetSpec& target) {
    hash.add(target.format);
    hash.add(target.width);
    hash.add(target.height);
    hash.add(target.levels);
    hash.add(target.samples);
}

}  // namespace

std::uint64_t hashOf(const Dressing& dressing) {
    if (dressing.own.empty()) return 0;
    PlanHash hash;
    for (const Material& m : dressing.own) hash.add(contentHash(m));
    for (const Index m : dressing.materialOfInstance) hash.add(m);
    return hash.value();
}

std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment) {
    PlanHash hash;
    hash.add(stage.scene.contentHash);
    hash.add(stage.dressingHash);
    hash.add(environment.contentHash);
    hash.add(plan.mapFromWorld);
    hash.add(plan.environmentIntensity);
    hash.add(plan.anisotropy);
    for (const std::size_t i : passes) {
        const Pass& pass = plan.passes[i];
        hash.add(pass.kind);
        if (pass.kind == PassKind::prefilter) hash.add(plan.probeSamples);
        if (pass.kind == PassKind::gaussian) {
            hash.add(pass.blur.size);
            hash.add(pass.blur.stdev);
            hash.add(pass.axis);
        }
        hash.add(pass.face);
        hash.add(pass.sky);
        if (traces(pass)) {
            addEverything(hash, stage);
            hash.add(stage.request.accuracy.bounces);
            hash.add(stage.request.effects.emission);
            hash.add(stage.request.effects.refraction);
        }
        addTarget(hash, plan.targets[pass.target]);
        for (const TargetId read : pass.reads) {
            // A map that outlives the frame is known by its key, others by the passes above.
            hash.add(plan.targets[read].residentKey);
            addTarget(hash, plan.targets[read]);
        }
        for (const View& view : pass.views) addView(hash, view);
        for (const ReflectedPicture& r : pass.reflections) {
            hash.add(r.origin);
            hash.add(r.scale);
            hash.add(r.pixelsPerSlope);
            hash.add(r.samples);
            hash.add(r.center);
            hash.add(r.proxyMin);
            hash.add(r.proxyMax);
            hash.add(r.normal);
            hash.add(r.ownFromMap);
        }
        addDraws(hash, pass.depthDraws, stage);
        addDraws(hash, pass.opaqueDraws, stage);
        addDraws(hash, pass.blendedDraws, stage);
    }
    return hash.value();
}

}  // namespace clerestory
