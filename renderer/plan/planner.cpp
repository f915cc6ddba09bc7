#include "plan/planner.h"

#include "plan/effects/background.h"
#include "plan/effects/channels.h"
#include "plan/effects/display.h"
#include "plan/effects/filters.h"
#include "plan/effects/lens_tiles.h"
#include "plan/effects/ray_tracing.h"
#include "plan/effects/shadows.h"
#include "plan/effects/supersampling.h"
#include "plan/effects/surface_light.h"
#include "plan/effects/view_context.h"
#include "plan/explain.h"
#include "plan/graph/plan_hash.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace clerestory {
namespace {

bool hasFloatOutput(const FrameRequest& request) {
    const OutputFormat format = request.output.format;
    return format == OutputFormat::npy || format == OutputFormat::exr ||
           format == OutputFormat::json;
}

// The target of the root view.
TargetSpec mainTarget(const FrameRequest& request) {
    const bool color = request.output.channel == Channel::color;
    // Alpha is a difference of two pictures.
    const bool transparent = color && isTransparent(request.background);
    return {.name = color ? "radiance" : "numbers",
            .format = hasFloatOutput(request) || transparent ? Format::rgba32f : Format::rgba16f,
            .width = request.width,
            .height = request.height,
            .depth = true};
}

FramePlan planOf(const FrameContext& context, const FrameRequest& request,
                 const ViewSettings& settings) {
    FramePlan plan;
    plan.width = request.width;
    plan.height = request.height;
    plan.channel = request.output.channel;
    plan.layer = request.output.layer;
    plan.fewPrograms = context.limits.fewPrograms;
    plan.transparent = plan.channel == Channel::color && isTransparent(request.background);
    plan.anisotropy = settings.accuracy.anisotropy;
    plan.environment = context.environment.name;
    plan.environmentIntensity = settings.environmentIntensity;
    plan.curvedSamples = settings.accuracy.curvedSamples;
    const double diagonal = lastingBounds(context.scene, context.pose).diagonal();
    plan.inverseDiagonal = diagonal > 0.0 ? 1.0 / diagonal : 1.0;
    plan.mapFromWorld = settings.mapFromWorld;
    if (plan.channel == Channel::color) {
        plan.lights =
            placedLights(lightsWith(lightsOf(context.scene, context.pose), request.lights),
                         context.pose, context.environment, glm::transpose(settings.mapFromWorld),
                         settings.environmentIntensity);
    }
    return plan;
}

// The views of a frame: one, or those of the tiles of its lens.
struct RootViews {
    ViewTask frame;
    std::vector<LensTile> tiles;
    std::vector<ViewTask> tasks;
};
RootViews rootViews(FramePlan& plan, ViewTask frame, Preset preset) {
    RootViews roots{.frame = std::move(frame)};
    if (plan.lens) {
        roots.tiles = tilesOf(plan.lens->lens, tileDensity(preset));
        roots.tasks = tileTasks(plan, roots.tiles, roots.frame);
    } else {
        roots.tasks = {roots.frame};
    }
    return roots;
}

// Makes all views choose one method for each subject.
void agree(ViewContext& views, const FramePlan& plan, const RootViews& roots) {
    if (roots.tasks.size() < 2) return;
    FramePlan trial = plan;
    PlanBuilder builder(trial);
    ViewContext trialViews(views.frame, views.stage, builder);
    const auto before = static_cast<std::ptrdiff_t>(trial.decisions.size());
    for (const ViewTask& task : roots.tasks) planView(trialViews, task);
    views.agreed = agreedMethods({trial.decisions.begin() + before, trial.decisions.end()});
}

void add(SeenView& all, SeenView seen) {
    std::move(seen.surfaces.begin(), seen.surfaces.end(), std::back_inserter(all.surfaces));
    all.clusters += seen.clusters;
    all.culled += seen.culled;
    all.mapsLeftOut += seen.mapsLeftOut;
    all.maxLights = std::max(all.maxLights, seen.maxLights);
    all.anyLit |= seen.anyLit;
    all.anyEmissive |= seen.anyEmissive;
}

// Adds the decisions of a colour frame to the plan, without its passes. Returns what each view
// shows.
std::vector<SeenView> seenInColor(const FrameContext& context, const Stage& stage,
                                  const RootViews& roots, FramePlan& plan) {
    FramePlan inColor = plan;
    PlanBuilder builder(inColor);
    ViewContext views(context, stage, builder);
    agree(views, plan, roots);
    std::vector<SeenView> all;
    std::uint32_t mirrors = 0;
    for (const ViewTask& task : roots.tasks) {
        all.push_back(planView(views, task));
        mirrors = labelThrough(all.back(), mirrors);
    }
    plan.decisions = std::move(inColor.decisions);
    return all;
}

// Adds what is derived from the surfaces of the channel.
void planLabels(FramePlan& plan, const FrameContext& context, const FrameRequest& request,
                const Stage& stage, const ViewTask& frame) {
    const bool direct = plan.layer == OutputLayer::direct;
    if (plan.channel == Channel::flow)
        planFlow(plan, context, stage, request, frame);
    else if (plan.channel == Channel::instances && direct)
        planInstances(plan, stage, frame);
    else if (plan.channel == Channel::instances)
        planLayerInstances(plan, context, stage, frame);
    else if (!direct)
        planLayer(plan, context, stage, request, frame);
}

void planChannelFrame(const FrameContext& context, const FrameRequest& request, const Stage& stage,
                      const RootViews& roots, FramePlan& plan) {
    std::vector<SeenView> seen;
    if (plan.channel == Channel::through) {
        seen = seenInColor(context, stage, roots, plan);
    } else {
        const std::vector<std::uint32_t> labels = labelsOf(stage.scene, plan.channel, request);
        for (const ViewTask& task : roots.tasks) {
            seen.push_back(seenFrom(stage, task.view));
            if (plan.layer == OutputLayer::direct) {
                labelInstances(seen.back(), labels);
            } else {
                labelMirrors(seen.back());
            }
        }
    }
    for (std::size_t i = 0; i < seen.size(); ++i) planChannel(plan, roots.tasks[i], seen[i]);
    plan.output = roots.frame.target;
    if (plan.lens) planAssembly(plan, roots.tiles, roots.tasks, roots.frame);
    planLabels(plan, context, request, stage, roots.frame);
    explainFilters(plan, request.filters);
}

Observer observerOf(const RootViews& roots) {
    Observer observer;
    for (const ViewTask& task : roots.tasks) observer.views.push_back(task.view);
    if (roots.tasks.empty()) return observer;  // the lens shows nothing
    const ViewTask& first = roots.tasks.front();
    observer.pixel = 2.0 / (first.view.clipFromView[1][1] * first.height);
    return observer;
}

void planColorFrame(const FrameContext& context, const FrameRequest& request, const Stage& stage,
                    const RootViews& roots, FramePlan& plan) {
    PlanBuilder builder(plan);
    planShadows(plan, builder, context, stage, observerOf(roots),
                double(request.width) * request.height);
    ViewContext views(context, stage, builder);
    agree(views, plan, roots);
    SeenView seen;
    std::vector<ViewTask> drawn = roots.tasks;  // with the targets of their finished pictures
    const auto exposureFactor = static_cast<float>(std::exp2(request.exposure));
    for (ViewTask& task : drawn) {
        const std::size_t firstPass = plan.passes.size();
        add(seen, planBackground(views, task, request.background, task.target));
        planSupersampling(builder, firstPass, task.target, request, exposureFactor);
    }
    planRays(plan, context, stage);
    const TargetId radiance =
        plan.lens ? planAssembly(plan, roots.tiles, drawn, roots.frame) : drawn.front().target;
    explainOmissions(plan, stage, seen);
    explainBackground(plan, request.background);
    const TargetId picture = planFilters(plan, request.filters, radiance, exposureFactor);
    if (hasFloatOutput(request)) {
        plan.output = picture;
        plan.skipped.push_back(
            {"toneMap", Effect::base, "the output format holds linear radiance"});
    } else {
        planDisplay(plan, request, picture, exposureFactor, context.limits.display);
    }
}

}  // namespace

FieldError unknownClip(const Scene& scene) {
    std::string names;
    for (const Clip& clip : scene.clips) names += (names.empty() ? "one of: " : ", ") + clip.name;
    return {"/clip", "the scene has no animation of this name",
            names.empty() ? "none: the scene has no animations" : names};
}

FieldError unknownVariant(const Scene& scene) {
    std::string names;
    for (const Variant& variant : scene.variants) {
        names += (names.empty() ? "one of: " : ", ") + variant.name;
    }
    return {"/variant", "the scene has no material variant of this name",
            names.empty() ? "none: the scene has no variants" : names};
}

bool hasVariant(const Scene& scene, const std::optional<std::string>& name) {
    return !name || std::any_of(scene.variants.begin(), scene.variants.end(),
                                [&](const Variant& variant) { return variant.name == *name; });
}

FramePlan planFrame(const FrameContext& context, const FrameRequest& request) {
    if (std::vector<FieldError> errors = problems(request); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    const ViewSettings settings =
        viewSettings(request, context.scene, context.limits.maxAnisotropy);
    FramePlan plan = planOf(context, request, settings);
    planSurfaceLight(plan, context, request);
    plan.composition = explained(request.parts);
    for (const auto& lines :
         {explained(context.scene, compositionOf(request)), explained(request.lights)}) {
        plan.composition.insert(plan.composition.end(), lines.begin(), lines.end());
    }
    const MaterialBindings materials =
        bindMaterials(context.scene, context.pose, request.overrides, request.variant);
    plan.materials = materials.own;
    const std::vector<Surface> surfaces = surfacesOf(context.scene, materials);
    const std::vector<std::uint64_t> ownHashes = ownHashesOf(materials);
    const Stage stage{.scene = context.scene,
                      .pose = context.pose,
                      .settings = settings,
                      .materials = materials,
                      .materialsHash = hashOf(materials, ownHashes),
                      .ownHashes = ownHashes,
                      .surfaceLight = plan.surfaceLight,
                      .surfaces = surfaces,
                      .lights = plan.lights,
                      .environment = context.environment,
                      .fewPrograms = context.limits.fewPrograms};
    ViewTask frame{.view = requestedView(request.camera, context.scene, context.pose, request.width,
                                         request.height),
                   .width = request.width,
                   .height = request.height,
                   .target = PlanBuilder(plan).addTarget(mainTarget(request)),
                   .mirrorsLeft = request.accuracy.generations,
                   .probeGeneration = request.accuracy.generations};
    if (auto lens = requestedLens(request.camera, context.scene, context.pose, request.width,
                                  request.height)) {
        plan.lens = FrameLens{*std::move(lens), frame.view};
    }
    const RootViews roots = rootViews(plan, std::move(frame), request.accuracy.preset);
    if (plan.channel == Channel::color) {
        planColorFrame(context, request, stage, roots, plan);
    } else {
        planChannelFrame(context, request, stage, roots, plan);
    }
    return plan;
}

}  // namespace clerestory
