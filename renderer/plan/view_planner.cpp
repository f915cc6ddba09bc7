// Plans one view: visible surfaces, a method for each by the effects, and the passes.
#include "plan/effects/view_context.h"

#include "plan/effects/curved_reflection.h"
#include "plan/effects/emitter_coverage.h"
#include "plan/effects/environment_map.h"
#include "plan/effects/method_choice.h"
#include "plan/effects/planar_reflection.h"
#include "plan/effects/ray_tracing.h"
#include "plan/effects/refraction.h"

#include <algorithm>

namespace clerestory {
namespace {

// The surfaces that the view omits. Only the requested view shows a shadow catcher. A captured view
// also omits occluded moving objects, so that their motion does not invalidate the cube.
std::vector<std::size_t> hiddenFrom(const ViewContext& context, const ViewTask& task) {
    const Stage& stage = context.stage;
    std::vector<std::size_t> hidden = task.hidden;
    if (stage.scene.shadowCatcher && (task.generation > 0 || task.captured)) {
        for (std::size_t i = 0; i < stage.surfaces.size(); ++i) {
            if (stage.surfaces[i].instance == stage.scene.ground) hidden.push_back(i);
        }
        std::sort(hidden.begin(), hidden.end());
        hidden.erase(std::unique(hidden.begin(), hidden.end()), hidden.end());
    }
    if (context.moves.empty() || !task.captured) return hidden;
    std::vector<Occluder> occluders = occludersOf(stage, task.view);
    std::erase_if(occluders, [&](const Occluder& occluder) {
        return std::binary_search(hidden.begin(), hidden.end(), occluder.surface);
    });
    for (std::size_t i = 0; i < stage.surfaces.size() && !occluders.empty(); ++i) {
        const Instance& instance = stage.scene.instances[stage.surfaces[i].instance];
        if (!context.moves[stage.surfaces[i].instance]) continue;
        const Bounds box =
            transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]),
                        eyeFromLocal(task.view, stage.pose.worldFromNode[instance.node]));
        if (findOccluder(occluders, task.view, box) != nullptr) hidden.push_back(i);
    }
    std::sort(hidden.begin(), hidden.end());
    return hidden;
}

}  // namespace

SeenView planView(ViewContext& context, const ViewTask& task) {
    const Stage& stage = context.stage;
    if (task.generation == 0) context.occluders = occludersOf(stage, task.view);
    SeenView seen = seenFrom(stage, task.view, hiddenFrom(context, task));
    DrawScene drawn{.purpose = task.purpose,
                    .face = task.face,
                    .view = task.view,
                    .sky = stage.settings.skyVisible && !task.background.replacesMap(),
                    .background = task.background};
    if (seen.anyLit) drawn.environment = environmentTarget(context);
    if (drawn.sky || drawn.environment != kNoTarget) drawn.map = context.frame.environment.name;

    planPlanarReflections(context, task, seen, drawn);
    planCurvedReflections(context, task, seen, drawn);
    planRoughReflections(context, task, seen);
    chooseRefraction(context, task, seen);

    if (context.frame.limits.rays == Rays::shader) leaveOutExcessMaps(seen);

    DrawLists lists = drawLists(seen);
    const char* requested = lists.depth.empty()
                                ? "the requested view; no depth prepass, %.1f layers predicted"
                                : "the requested view; depth first, %.1f layers predicted";
    drawn.depthDraws = std::move(lists.depth);
    drawn.opaqueDraws = std::move(lists.opaque);
    const auto firstGlass = std::find_if(lists.through.begin(), lists.through.end(),
                                         [](const DrawLists::Behind& b) { return b.glass; });
    for (auto it = lists.through.begin(); it != firstGlass; ++it) {
        drawn.blendedDraws.push_back(it->draw);
    }
    addDrawnPass(context, task,
                 {.name = nameOf(task.subject),
                  .subject = task.subject,
                  .effect = task.effect,
                  .generation = task.generation,
                  .target = task.target,
                  .reason = task.reason.empty() ? formatted(requested, seen.overdraw) : task.reason,
                  .work = drawn});
    planEmitterCoverage(context, task, seen);
    addGlassLayers(context, task, seen, drawn, {firstGlass, lists.through.end()});
    return seen;
}

}  // namespace clerestory
