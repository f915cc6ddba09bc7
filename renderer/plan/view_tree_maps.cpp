// Stored maps of a view tree: prefiltered, blurred where a material asks for it, and kept.
#include "plan/graph/plan_hash.h"
#include "plan/view_tree.h"

#include <bit>

namespace clerestory {

TargetId ViewTree::environmentTarget() {
    if (environmentTarget_ == kNoTarget && plan_.environmentIntensity > 0.0f) {
        environmentTarget_ = mapTarget(environment_);
    }
    return environmentTarget_;
}

TargetId ViewTree::mapTarget(const EnvironmentMap& map, const MapBlur& blur) {
    const auto [memo, isNew] =
        mapTargets_.try_emplace(MapKey{map.name, blur.size, blur.stdev}, kNoTarget);
    if (!isNew) return memo->second;
    const Accuracy& a = stage_.request.accuracy;
    PlanHash hash;
    hash.add(map.contentHash);
    hash.add(a.environmentSize);
    hash.add(blur.changes() ? a.probeSamples : a.environmentSamples);
    if (blur.changes()) {
        hash.add(blur.size);
        hash.add(blur.stdev);
    }
    memo->second = addTarget({.name = "environment:" + map.name,
                              .kind = TargetKind::cube,
                              .format = Format::rgba16f,
                              .width = a.environmentSize,
                              .height = a.environmentSize,
                              .levels = roughnessLevels(a.environmentSize),
                              .residentKey = hash.value()});
    const TargetId target = memo->second;
    const std::string name = plan_.targets[target].name;
    if (resident_.keys.contains(hash.value())) {
        plan_.skipped.push_back({name, Effect::base, "resident and unchanged"});
        return target;
    }
    const std::size_t first = plan_.passes.size();
    const char* reason = "lights the scene and is not resident at this accuracy";
    if (blur.changes()) {
        const TargetId blurred = addBlur(name, blur, map.faceSize, 0, kNoTarget, map.name);
        plan_.passes.push_back({.name = name,
                                .effect = Effect::environmentReflection,
                                .target = target,
                                .reason = reason,
                                .work = PrefilterCube{blurred, a.probeSamples}});
    } else {
        plan_.passes.push_back({.name = name,
                                .target = target,
                                .reason = reason,
                                .work = PrefilterMap{map.name, a.environmentSamples}});
    }
    keyedPasses_.emplace_back(first, plan_.passes.size());
    return target;
}

TargetId ViewTree::addBlur(const std::string& name, const MapBlur& blur, std::uint32_t faceSize,
                           std::uint32_t generation, TargetId source, const std::string& map) {
    TargetSpec spec{.name = name + ":blur",
                    .kind = TargetKind::cube,
                    .format = Format::rgba16f,
                    .width = faceSize,
                    .height = faceSize,
                    .levels = static_cast<std::uint32_t>(std::bit_width(faceSize))};
    const TargetId result = addTarget(spec);
    spec.levels = 1;
    const TargetId between = addTarget(spec);
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const TargetId from = axis == 0 ? source : axis == 1 ? result : between;
        plan_.passes.push_back({.name = name + ":blur",
                                .effect = Effect::environmentReflection,
                                .generation = generation,
                                .target = axis == 1 ? between : result,
                                .reason = "the map is asked for with a Gaussian blur",
                                .work = BlurCube{from, from == kNoTarget ? map : "", blur, axis}});
    }
    plan_.passes.push_back({.name = name + ":levels",
                            .effect = Effect::environmentReflection,
                            .generation = generation,
                            .target = result,
                            .reason = "filtered samples read it blurred",
                            .work = BuildLevels{}});
    return result;
}

}  // namespace clerestory
