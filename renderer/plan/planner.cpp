// The walk over what a frame could need, and the reasons.
#include "plan/planner.h"

#include "plan/effects/filters.h"
#include "plan/effects/lighting.h"
#include "plan/features.h"
#include "plan/graph/plan_hash.h"
#include "plan/view_tree.h"
#include "plan/visibility/draws.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace clerestory {
namespace {

TargetId addTarget(FramePlan& plan, TargetSpec spec) {
    plan.targets.push_back(std::move(spec));
    return static_cast<TargetId>(plan.targets.size() - 1);
}

// What the root view leaves out, effect by effect: what no surface calls for, and what is off.
void explainEffects(FramePlan& plan, const Stage& stage, const SeenView& seen) {
    const auto skip = [&](const char* name, Effect effect, const char* reason) {
        plan.skipped.push_back({name, effect, reason});
    };
    const auto anywhere = [&](auto&& is) {
        return std::any_of(stage.surfaces.begin(), stage.surfaces.end(), is);
    };
    const auto inView = [&](auto&& is) {
        return std::any_of(seen.surfaces.begin(), seen.surfaces.end(),
                           [&](const SeenSurface& s) { return is(*s.surface); });
    };
    const auto explain = [&](const char* name, Effect effect, bool on, const char* none,
                             const char* unseen, auto&& is) {
        if (!anywhere(is))
            skip(name, effect, none);
        else if (!on)
            skip(name, effect, "switched off");
        else if (!inView(is))
            skip(name, effect, unseen);
    };
    const Effects& on = stage.request.effects;
    explain("emission", Effect::emission, on.emission, "the scene has no emissive material",
            "no emissive surface in view", [](const Surface& s) { return s.emitter; });
    explain("glass", Effect::refraction, on.refraction, "the scene has no transmissive material",
            "no glass in view", [](const Surface& s) { return s.glass != Glass::none; });
    explain("mirrors", Effect::planarReflection, on.planarReflection,
            "the scene has no flat mirror", "no flat mirror in view",
            [](const Surface& s) { return s.reflector == Reflector::flat; });
    explain("probes", Effect::environmentReflection, on.environmentReflection,
            "the scene has no curved mirror", "no curved mirror in view",
            [](const Surface& s) { return s.reflector == Reflector::curved; });
}

void explainView(FramePlan& plan, const FrameRequest& request, const SeenView& seen) {
    const auto skip = [&](const char* name, std::string reason) {
        plan.skipped.push_back({name, Effect::base, std::move(reason)});
    };
    if (seen.culled > 0) {
        skip("clusters", std::to_string(seen.culled) + " of " + std::to_string(seen.clusters) +
                             " clusters are outside the view");
    }
    if (seen.mostLights > kMaxLightsPerDraw) {
        skip("lights", std::to_string(seen.mostLights) + " lights reach one draw; the strongest " +
                           std::to_string(kMaxLightsPerDraw) + " are used");
    }
    if (!request.environment.visible) skip("sky", "the request hides the environment");
    if (!seen.anyLit || plan.environmentIntensity <= 0.0f) {
        plan.skipped.push_back({"environment:" + plan.environment, Effect::base,
                                seen.anyLit ? "its intensity is 0" : "nothing in view is lit"});
    }
}

// What each surface is seen as, by what the tree has made of it.
void nameThrough(SeenView& seen) {
    for (SeenSurface& s : seen.surfaces) {
        if (s.features & (FEATURE_GLASS | FEATURE_TRACED_GLASS))
            s.through = throughGlass;
        else if (s.features & (FEATURE_PROBE | FEATURE_TRACED_REFLECTION))
            s.through = throughCubeOrRays;
        else if (s.features & FEATURE_MIRROR)
            s.through = throughFirstMirror + s.reflection;  // flat mirrors' pictures come first
        else
            s.through =
                s.surface->reflector == Reflector::none ? throughDirect : throughEnvironment;
        // Numbers reflect nothing and follow no rays.
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
                           .reason = "the request asks for numbers instead of colour",
                           .work = std::move(work)});
}

void planDisplay(FramePlan& plan, const FrameRequest& request, TargetId color,
                 float exposureFactor) {
    const TargetSpec display{.format = Format::srgba8, .width = plan.width, .height = plan.height};
    TargetSpec toneMapped = display;
    toneMapped.name = "display";
    plan.output = addTarget(plan, toneMapped);
    ToneMapping toneMapping;
    toneMapping.source = color;
    toneMapping.curve = request.toneMap;
    toneMapping.exposureFactor = exposureFactor;
    toneMapping.edgeFilterFollows = request.accuracy.edgeFilter;
    plan.passes.push_back({.name = "toneMap",
                           .target = plan.output,
                           .reason = "radiance becomes display colour",
                           .work = toneMapping});
    if (!request.accuracy.edgeFilter) {
        plan.skipped.push_back({"edgeFilter", Effect::base, "not asked for at this accuracy"});
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

}  // namespace

FieldError noSuchClip(const Scene& scene) {
    std::string names;
    for (const Clip& clip : scene.clips) names += (names.empty() ? "one of: " : ", ") + clip.name;
    return {"/clip", "the scene has no animation of this name",
            names.empty() ? "none: nothing in the scene moves" : names};
}

FramePlan planFrame(const FrameContext& context, const FrameRequest& request) {
    const auto& [scene, pose, environment, maps, resident, limits] = context;
    if (std::vector<FieldError> errors = problems(request); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    FramePlan plan;
    plan.width = request.width;
    plan.height = request.height;
    plan.channel = request.output.channel;
    plan.anisotropy = std::min(request.accuracy.anisotropy, std::max(1u, limits.maxAnisotropy));
    plan.environment = environment.name;
    plan.environmentIntensity = static_cast<float>(request.environment.intensity);
    plan.curvedSamples = request.accuracy.curvedSamples;
    const double diagonal = lastingBounds(scene, pose).diagonal();
    plan.perMetre = diagonal > 0.0 ? 1.0 / diagonal : 1.0;
    const glm::dmat3 fromMap = worldFromMap(request, scene);
    plan.mapFromWorld = glm::transpose(fromMap);

    const View view = requestedView(request.camera, scene, pose, request.width, request.height);
    const bool color = request.output.channel == Channel::color;
    if (color) {
        plan.lights = placedLights(scene, pose, environment, fromMap, plan.environmentIntensity);
    }
    const MaterialBindings materials = bindMaterials(scene, request.overrides);
    plan.materials = materials.own;
    const std::vector<Surface> surfaces = surfacesOf(scene, materials);
    const Stage stage{.scene = scene,
                      .pose = pose,
                      .request = request,
                      .materials = materials,
                      .materialsHash = hashOf(materials),
                      .surfaces = surfaces,
                      .lights = plan.lights};

    const bool floats =
        request.output.format == OutputFormat::npy || request.output.format == OutputFormat::exr;
    TargetSpec main{
        .name = color ? "radiance" : "numbers",
        .format = floats ? Format::rgba32f : Format::rgba16f,
        .width = plan.width,
        .height = plan.height,
        .samples = color ? std::min(request.accuracy.samples, std::max(1u, limits.maxSamples)) : 1,
        .depth = true};
    main.samples = std::bit_floor(main.samples);  // drivers offer powers of two
    const TargetId target = addTarget(plan, std::move(main));
    const ViewJob root{.view = view,
                       .width = plan.width,
                       .height = plan.height,
                       .target = target,
                       .mirrorsLeft = request.accuracy.generations,
                       .probeGeneration = request.accuracy.generations};
    if (!color) {
        plan.output = target;
        SeenView seen;
        if (request.output.channel == Channel::through) {
            // The colour's decisions, without its passes.
            FramePlan inColor = plan;
            seen = ViewTree(inColor, stage, context).add(root);
            nameThrough(seen);
            plan.decisions = std::move(inColor.decisions);
        } else {
            seen = seenFrom(stage, view);
        }
        planChannel(plan, view, seen, target);
        explainFilters(plan, request.filters);
        return plan;
    }

    ViewTree tree(plan, stage, context);
    const SeenView seen = tree.add(root);
    if (std::any_of(plan.passes.begin(), plan.passes.end(),
                    [](const Pass& pass) { return followsRays(pass); })) {
        plan.materialOfInstance = materials.materialOfInstance;
        plan.hitFeatures = featuresOfAll(stage);
        plan.bounces = request.accuracy.bounces;
    }
    explainView(plan, request, seen);
    explainEffects(plan, stage, seen);
    const auto exposureFactor = static_cast<float>(std::exp2(request.exposure));
    const TargetId picture = planFilters(plan, request.filters, target, exposureFactor);
    if (floats) {
        plan.output = picture;
        plan.skipped.push_back({"toneMap", Effect::base, "the request asks for linear radiance"});
    } else {
        planDisplay(plan, request, picture, exposureFactor);
    }
    return plan;
}

}  // namespace clerestory
