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
    // Colour of a transparent picture is divided by its alpha at the end, which needs its digits.
    const TargetSpec display{.format = plan.transparent ? Format::rgba16f : Format::srgba8,
                             .storage = plan.transparent ? Storage::driver : storage,
                             .width = plan.width,
                             .height = plan.height};
    TargetSpec toneMapped = display;
    toneMapped.name = "display";
    plan.output = addTarget(plan, toneMapped);
    ToneMapping toneMapping;
    toneMapping.source = radiance;
    toneMapping.curve = request.toneMap;
    toneMapping.exposureFactor = exposureFactor;
    toneMapping.edgeFilterFollows = request.accuracy.edgeFilter;
    toneMapping.transparent = plan.transparent;
    plan.passes.push_back({.name = "toneMap",
                           .target = plan.output,
                           .reason = "converts radiance to display colour",
                           .work = toneMapping});
    if (request.accuracy.edgeFilter) {
        TargetSpec filtered = display;
        filtered.name = "filtered";
        const TargetId before = plan.output;
        const bool ofSamples = request.accuracy.samples > 1;
        plan.output = addTarget(plan, filtered);
        plan.passes.push_back(
            {.name = "edgeFilter",
             .target = plan.output,
             .reason = ofSamples ? "smooths what samples leave of edges" : "smooths edges",
             .work = EdgeFilter{
                 {before}, plan.transparent, request.toneMap != ToneMap::linear, ofSamples}});
    } else {
        plan.skipped.push_back({"edgeFilter", Effect::base, "not requested at this accuracy"});
    }
    if (!plan.transparent) return;
    TargetSpec straight = display;
    straight.name = "straight";
    straight.format = Format::srgba8;
    const TargetId premultiplied = plan.output;
    plan.output = addTarget(plan, straight);
    plan.passes.push_back({.name = "straightAlpha",
                           .target = plan.output,
                           .reason = "the file format holds straight alpha",
                           .work = StraightAlpha{{premultiplied}}});
}

}  // namespace clerestory
