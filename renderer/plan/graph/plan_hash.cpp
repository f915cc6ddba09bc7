// What a map's pixels depend on.
#include "plan/graph/plan_hash.h"

namespace clerestory {
namespace {

void addTarget(PlanHash& hash, const TargetSpec& target) {
    hash.add(target.format);
    hash.add(target.width);
    hash.add(target.height);
    hash.add(target.levels);
    hash.add(target.samples);
}

}  // namespace

std::uint64_t hashOf(const MaterialBindings& materials) {
    if (materials.own.empty()) return 0;
    PlanHash hash;
    for (const Material& m : materials.own) hash.add(contentHash(m));
    for (const Index m : materials.materialOfInstance) hash.add(m);
    return hash.value();
}

std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment) {
    PlanHash hash;
    hash.add(stage.scene.contentHash);
    hash.add(stage.materialsHash);
    hash.add(environment.contentHash);
    hash.add(plan.mapFromWorld);
    hash.add(plan.environmentIntensity);
    hash.add(plan.anisotropy);
    for (const std::size_t i : passes) {
        const Pass& pass = plan.passes[i];
        hash.add(pass.kind());
        std::visit([&](const auto& work) { work.addTo(hash, stage); }, pass.work);
        addTarget(hash, plan.targets[pass.target]);
        for (const TargetId read : pass.reads()) {
            // A map that outlives the frame is known by its key, others by the passes above.
            hash.add(plan.targets[read].residentKey);
            addTarget(hash, plan.targets[read]);
        }
    }
    return hash.value();
}

}  // namespace clerestory
