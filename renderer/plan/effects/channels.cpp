#include "plan/effects/channels.h"

#include "plan/graph/features.h"

namespace clerestory {

void labelThrough(SeenView& seen) {
    for (SeenSurface& s : seen.surfaces) {
        if (s.features & (FEATURE_GLASS | FEATURE_TRACED_GLASS))
            s.through = throughGlass;
        else if (s.features & (FEATURE_PROBE | FEATURE_TRACED_REFLECTION))
            s.through = throughCubeOrRays;
        else if (s.features & FEATURE_MIRROR)
            s.through = throughFirstMirror + s.reflection;  // mirrored views come first
        else
            s.through =
                s.surface->reflector == Reflector::none ? throughDirect : throughEnvironment;
        // Channels are not reflected and need no rays.
        s.reflection = kNoReflection;
        s.features &= ~(FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS);
    }
}

void planChannel(FramePlan& plan, const View& view, const SeenView& seen, TargetId target) {
    DrawLists draws = drawLists(seen);
    DrawChannel work{.view = view, .draws = std::move(draws.opaque)};
    for (const DrawLists::Behind& item : draws.through) work.draws.push_back(item.draw);
    plan.passes.push_back({.name = "channel",
                           .target = target,
                           .reason = "the request selects a data channel instead of colour",
                           .work = std::move(work)});
}

}  // namespace clerestory
