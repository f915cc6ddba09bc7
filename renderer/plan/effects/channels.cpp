#include "plan/effects/channels.h"

#include "plan/graph/features.h"

#include <algorithm>

namespace clerestory {

std::uint32_t labelThrough(SeenView& seen, std::uint32_t firstMirror) {
    std::uint32_t nextMirror = firstMirror;
    for (SeenSurface& s : seen.surfaces) {
        if (s.features & (FEATURE_GLASS | FEATURE_TRACED_GLASS))
            s.through = throughGlass;
        else if (s.features & (FEATURE_PROBE | FEATURE_TRACED_REFLECTION))
            s.through = throughCubeOrRays;
        else if (s.features & FEATURE_MIRROR) {
            s.through = throughFirstMirror + firstMirror + s.reflection;  // mirrored views first
            nextMirror = std::max(nextMirror, firstMirror + s.reflection + 1);
        } else
            s.through =
                s.surface->reflector == Reflector::none ? throughDirect : throughEnvironment;
        // Channels are not reflected and need no rays.
        s.reflection = kNoReflection;
        s.features &= ~(FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS);
    }
    return nextMirror;
}

void planChannel(FramePlan& plan, const ViewTask& task, const SeenView& seen) {
    DrawLists draws = drawLists(seen);
    DrawChannel work{.view = task.view, .draws = std::move(draws.opaque)};
    for (const DrawLists::Behind& item : draws.through) work.draws.push_back(item.draw);
    const std::string& view = task.subject.name;
    plan.passes.push_back({.name = view.empty() ? "channel" : "channel:" + view,
                           .subject = task.subject,
                           .target = task.target,
                           .reason = "the request selects a data channel instead of colour",
                           .work = std::move(work)});
}

}  // namespace clerestory
