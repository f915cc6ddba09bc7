#include "plan/graph/plan_hash.h"

namespace clerestory {
namespace {

// Hashes everything except the name and the identity of the content.
void addTarget(PlanHash& hash, const TargetSpec& target) {
    const auto& [name, kind, format, storage, width, height, levels, depth, scratch, replaceable,
                 residentKey, partKey, inputsHash] = target;
    hash.add(kind);
    hash.add(format);
    hash.add(storage);
    // Other views make a scratch target larger.
    hash.add(scratch ? 0 : width);
    hash.add(scratch ? 0 : height);
    hash.add(levels);
    hash.add(depth);
}

}  // namespace

std::vector<std::uint64_t> ownHashesOf(const MaterialBindings& materials) {
    std::vector<std::uint64_t> hashes;
    for (const Material& m : materials.own) hashes.push_back(contentHash(m));
    return hashes;
}

std::uint64_t hashOf(const MaterialBindings& materials, std::span<const std::uint64_t> own) {
    if (materials.materialOfInstance.empty() && materials.hidden.empty()) return 0;
    PlanHash hash;
    for (const std::uint64_t m : own) hash.add(m);
    for (const Index m : materials.materialOfInstance) hash.add(m);
    for (const bool hidden : materials.hidden) hash.add(hidden);
    return hash.value();
}

std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment) {
    PlanHash hash;
    hash.add(stage.scene.contentHash);
    hash.add(plan.surfaceLight);
    hash.add(environment.contentHash);
    hash.add(plan.mapFromWorld);
    hash.add(plan.environmentIntensity);
    hash.add(plan.anisotropy);
    hash.add(plan.shadowSamples);
    for (const TargetId map : {plan.shadowMap, plan.shadowTints}) {
        hash.add(map == kNoTarget ? 0 : plan.targets[map].residentKey);
    }
    for (const std::size_t i : passes) {
        const Pass& pass = plan.passes[i];
        hash.add(pass.kind());
        std::visit([&](const auto& work) { addTo(hash, work, stage); }, pass.work);
        addTarget(hash, plan.targets[pass.target]);
        for (const TargetId read : pass.reads()) {
            // The key identifies a map that outlives the frame; the passes above identify others.
            hash.add(plan.targets[read].residentKey);
            addTarget(hash, plan.targets[read]);
        }
    }
    return hash.value();
}

}  // namespace clerestory
