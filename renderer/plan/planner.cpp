#include "plan/planner.h"

#include "plan/effects/channels.h"
#include "plan/effects/display.h"
#include "plan/effects/filters.h"
#include "plan/effects/ray_tracing.h"
#include "plan/effects/shadows.h"
#include "plan/effects/surface_light.h"
#include "plan/effects/view_context.h"
#include "plan/explain.h"
#include "plan/graph/plan_hash.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace clerestory {
namespace {

bool hasFloatOutput(const FrameRequest& request) {
    return request.output.format == OutputFormat::npy || request.output.format == OutputFormat::exr;
}

// The target of the root view.
TargetSpec mainTarget(const FrameRequest& request, const DeviceLimits& limits) {
    const bool color = request.output.channel == Channel::color;
    const std::uint32_t samples =
        color ? std::min(request.accuracy.samples, std::max(1u, limits.maxSamples)) : 1;
    return {.name = color ? "radiance" : "numbers",
            .format = hasFloatOutput(request) ? Format::rgba32f : Format::rgba16f,
            .width = request.width,
            .height = request.height,
            .samples = std::bit_floor(samples),  // drivers support powers of two
            .depth = true};
}

FramePlan planOf(const FrameContext& context, const FrameRequest& request,
                 const ViewSettings& settings) {
    FramePlan plan;
    plan.width = request.width;
    plan.height = request.height;
    plan.channel = request.output.channel;
    plan.anisotropy = settings.accuracy.anisotropy;
    plan.environment = context.environment.name;
    plan.environmentIntensity = settings.environmentIntensity;
    plan.curvedSamples = settings.accuracy.curvedSamples;
    const double diagonal = lastingBounds(context.scene, context.pose).diagonal();
    plan.perMetre = diagonal > 0.0 ? 1.0 / diagonal : 1.0;
    plan.mapFromWorld = settings.mapFromWorld;
    if (plan.channel == Channel::color) {
        plan.lights = placedLights(lightsWith(context.scene, request.lights), context.pose,
                                   context.environment, glm::transpose(settings.mapFromWorld),
                                   settings.environmentIntensity);
    }
    return plan;
}

// Adds the decisions of a colour frame to the plan, without its passes.
SeenView seenInColor(const FrameContext& context, const Stage& stage, const ViewTask& root,
                     FramePlan& plan) {
    FramePlan inColor = plan;
    PlanBuilder builder(inColor);
    ViewContext views(context, stage, builder);
    SeenView seen = planView(views, root);
    labelThrough(seen);
    plan.decisions = std::move(inColor.decisions);
    return seen;
}

void planChannelFrame(const FrameContext& context, const FrameRequest& request, const Stage& stage,
                      const ViewTask& root, FramePlan& plan) {
    const SeenView seen = plan.channel == Channel::through ? seenInColor(context, stage, root, plan)
                                                           : seenFrom(stage, root.view);
    planChannel(plan, root.view, seen, root.target);
    plan.output = root.target;
    explainFilters(plan, request.filters);
}

void planColorFrame(const FrameContext& context, const FrameRequest& request, const Stage& stage,
                    const ViewTask& root, FramePlan& plan) {
    PlanBuilder builder(plan);
    planShadows(plan, builder, context, stage, double(request.width) * request.height);
    ViewContext views(context, stage, builder);
    const SeenView seen = planView(views, root);
    planRays(plan, context, stage);
    explainOmissions(plan, stage, seen);
    const auto exposureFactor = static_cast<float>(std::exp2(request.exposure));
    const TargetId picture = planFilters(plan, request.filters, root.target, exposureFactor);
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
    const MaterialBindings materials =
        bindMaterials(context.scene, request.overrides, request.variant);
    plan.materials = materials.own;
    const std::vector<Surface> surfaces = surfacesOf(context.scene, materials);
    const Stage stage{.scene = context.scene,
                      .pose = context.pose,
                      .settings = settings,
                      .materials = materials,
                      .materialsHash = hashOf(materials),
                      .surfaceLight = plan.surfaceLight,
                      .surfaces = surfaces,
                      .lights = plan.lights,
                      .environment = context.environment};
    const ViewTask root{.view = requestedView(request.camera, context.scene, context.pose,
                                              request.width, request.height),
                        .width = request.width,
                        .height = request.height,
                        .target = PlanBuilder(plan).addTarget(mainTarget(request, context.limits)),
                        .mirrorsLeft = request.accuracy.generations,
                        .probeGeneration = request.accuracy.generations};
    if (plan.channel == Channel::color) {
        planColorFrame(context, request, stage, root, plan);
    } else {
        planChannelFrame(context, request, stage, root, plan);
    }
    return plan;
}

}  // namespace clerestory
