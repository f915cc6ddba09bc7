#include "plan/effects/display.h"

namespace clerestory {
namespace {

TargetId addTarget(FramePlan& plan, TargetSpec spec) {
    plan.targets.push_back(std::move(spec));
    return static_cast<TargetId>(plan.targets.size() - 1);
}

}  // namespace

void planDisplay(FramePlan& plan, const FrameRequest& request, TargetId radiance,
                 float exposureFactor, Storage storage) {
    const TargetSpec display{
        .format = Format::srgba8, .storage = storage, .width = plan.width, .height = plan.height};
    TargetSpec toneMapped = display;
    toneMapped.name = "display";
    plan.output = addTarget(plan, toneMapped);
    ToneMapping toneMapping;
    toneMapping.source = radiance;
    toneMapping.curve = request.toneMap;
    toneMapping.exposureFactor = exposureFactor;
    toneMapping.edgeFilterFollows = request.accuracy.edgeFilter;
    plan.passes.push_back({.name = "toneMap",
                           .target = plan.output,
                           .reason = "converts radiance to display colour",
                           .work = toneMapping});
    if (!request.accuracy.edgeFilter) {
        plan.skipped.push_back({"edgeFilter", Effect::base, "not requested at this accuracy"});
        return;
    }
    TargetSpec filtered = display;
    filtered.name = "filtered";
    const TargetId before = plan.output;
    plan.output = addTarget(plan, filtered);
    plan.passes.push_back({.name = "edgeFilter",
                           .target = plan.output,
                           .reason = "smooths edges",
                           .work = EdgeFilter{{before}}});
}

}  // namespace clerestory
