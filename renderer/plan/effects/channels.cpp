#include "plan/effects/channels.h"

#include "plan/effects/ray_tracing.h"
#include "plan/graph/features.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"
#include "scene/classes.h"

#include <algorithm>

namespace clerestory {

std::uint32_t labelThrough(SeenView& seen, std::uint32_t firstMirror) {
    std::uint32_t nextMirror = firstMirror;
    for (SeenSurface& s : seen.surfaces) {
        if (s.features & (FEATURE_GLASS | FEATURE_TRACED_GLASS))
            s.label = throughGlass;
        else if (s.features & (FEATURE_PROBE | FEATURE_TRACED_REFLECTION))
            s.label = throughCubeOrRays;
        else if (s.features & FEATURE_MIRROR) {
            s.label = throughFirstMirror + firstMirror + s.reflection;  // mirrored views first
            nextMirror = std::max(nextMirror, firstMirror + s.reflection + 1);
        } else
            s.label = s.surface->reflector == Reflector::none ? throughDirect : throughEnvironment;
        // Channels are not reflected and need no rays.
        s.reflection = kNoReflection;
        s.features &= ~(FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS);
    }
    return nextMirror;
}

std::vector<std::uint32_t> labelsOf(const Scene& scene, Channel channel,
                                    const FrameRequest& request) {
    if (channel == Channel::classId) return classesOf(scene, request.output.classes);
    if (channel != Channel::materialId) return {};
    const MaterialBindings originals = bindMaterials(scene, Pose{}, {}, request.variant);
    std::vector<std::uint32_t> labels;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        labels.push_back(originals.materialOf(scene, i) + 1);
    }
    return labels;
}

void labelInstances(SeenView& seen, std::span<const std::uint32_t> labels) {
    if (labels.empty()) return;
    for (SeenSurface& s : seen.surfaces) s.label = labels[s.surface->instance];
}

void labelMirrors(SeenView& seen) {
    for (SeenSurface& s : seen.surfaces) s.label = s.surface->reflector != Reflector::none;
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

namespace {

// Numbers the draws of the plan from 1 and returns what they show.
std::vector<SurfaceDraw> numberedDraws(FramePlan& plan) {
    std::vector<SurfaceDraw> numbered;
    for (Pass& pass : plan.passes) {
        auto* work = std::get_if<DrawChannel>(&pass.work);
        if (!work) continue;
        for (Draw& draw : work->draws) {
            numbered.push_back({draw.instance, draw.firstIndex, draw.label.value_or(0) != 0});
            draw.label = static_cast<std::uint32_t>(numbered.size());
        }
    }
    return numbered;
}

Projection thisFrame(const FramePlan& plan, const ViewTask& frame) {
    Projection projection{frame.view, {}, plan.width, plan.height};
    if (plan.lens) projection.lens = plan.lens->lens;
    return projection;
}

// Adds a pass that computes the output from the surfaces of pixels.
void addLabelPass(FramePlan& plan, const ViewTask& frame, std::string name, std::string reason,
                  PassWork work) {
    TargetSpec target = plan.targets[frame.target];
    target.name = name;
    target.storage = Storage::processor;
    target.depth = false;
    plan.output = PlanBuilder(plan).addTarget(std::move(target));
    plan.passes.push_back({.name = std::move(name),
                           .target = plan.output,
                           .reason = std::move(reason),
                           .work = std::move(work)});
}

void planLayerRays(FramePlan& plan, const FrameContext& context, const Stage& stage) {
    FrameContext traced = context;
    traced.needsRays = true;
    planRays(plan, traced, stage);
}

// Of a layer other than direct.
const char* subjectOf(OutputLayer layer) {
    return layer == OutputLayer::reflected ? "what mirrors and glass reflect"
                                           : "what is seen through glass";
}

Projection otherFrame(const FrameContext& context, const FrameRequest& request) {
    const CameraRequest& camera = request.output.flow->camera.value_or(request.camera);
    const Pose& pose = *context.flowPose;
    const std::uint32_t width = request.width, height = request.height;
    try {
        return {requestedView(camera, context.scene, pose, width, height),
                requestedLens(camera, context.scene, pose, width, height), width, height};
    } catch (const InvalidRequest& error) {
        throw InvalidRequest(below("/output/flow", error.errors()));
    }
}

}  // namespace

void planFlow(FramePlan& plan, const FrameContext& context, const Stage& stage,
              const FrameRequest& request, const ViewTask& frame) {
    if (plan.layer != OutputLayer::direct) planLayerRays(plan, context, stage);
    MeasureFlow work{.source = plan.output,
                     .draws = numberedDraws(plan),
                     .from = thisFrame(plan, frame),
                     .to = otherFrame(context, request),
                     .time = request.output.flow->time,
                     .layer = plan.layer};
    const std::string what = plan.layer == OutputLayer::direct
                                 ? "surfaces are"
                                 : std::string(subjectOf(plan.layer)) + " is";
    std::string reason = "where " + what + " at " + field::numberText(work.time) + " s";
    addLabelPass(plan, frame, "flow", std::move(reason), std::move(work));
}

void planLayer(FramePlan& plan, const FrameContext& context, const Stage& stage,
               const FrameRequest& request, const ViewTask& frame) {
    planLayerRays(plan, context, stage);
    FollowLayer work{.source = plan.output,
                     .draws = numberedDraws(plan),
                     .from = thisFrame(plan, frame),
                     .layer = plan.layer,
                     .labels = labelsOf(stage.scene, plan.channel, request)};
    addLabelPass(plan, frame, "layer", subjectOf(plan.layer), std::move(work));
}

void planLayerInstances(FramePlan& plan, const FrameContext& context, const Stage& stage,
                        const ViewTask& frame) {
    planLayerRays(plan, context, stage);
    CountLayer work{.source = plan.output,
                    .draws = numberedDraws(plan),
                    .from = thisFrame(plan, frame),
                    .layer = plan.layer};
    addLabelPass(plan, frame, "instances", subjectOf(plan.layer), std::move(work));
}

void planInstances(FramePlan& plan, const Stage& stage, const ViewTask& frame) {
    if (plan.lens) {
        throw InvalidRequest({{"/camera/lens", "conflicts with the channel instances",
                               "perspective without distortion, or orthographic"}});
    }
    MeasureInstances work{.source = plan.output, .view = frame.view};
    work.draws = std::get<DrawChannel>(plan.passes.back().work).draws;
    std::stable_sort(work.draws.begin(), work.draws.end(),
                     [](const Draw& a, const Draw& b) { return a.instance < b.instance; });
    for (std::uint32_t i = 0; i < work.draws.size(); ++i) {
        if (work.instances.empty() || work.instances.back().instance != work.draws[i].instance) {
            work.instances.push_back({.instance = work.draws[i].instance, .firstDraw = i});
        }
        ++work.instances.back().drawCount;
    }
    for (MeasureInstances::Alone& alone : work.instances) {
        const auto draws = std::span(work.draws).subspan(alone.firstDraw, alone.drawCount);
        const double guard = 2.0 + draws.front().pointSize;
        alone.rect =
            touchedPixels(coveredBy(draws, frame.view, stage), plan.width, plan.height, guard);
    }
    TargetSpec target = plan.targets[frame.target];
    target.name = "instances";
    target.depth = false;
    plan.passes.push_back({.name = "instances",
                           .target = PlanBuilder(plan).addTarget(std::move(target)),
                           .reason = std::to_string(work.instances.size()) +
                                     " instances may be in the frame; each is drawn alone",
                           .work = std::move(work)});
}

}  // namespace clerestory
