#include "plan/effects/ray_tracing.h"

#include "plan/graph/features.h"
#include "plan/graph/plan_hash.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/material_features.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <bit>
#include <string>

namespace clerestory {
namespace {

RayScene::MaterialProperties propertiesOf(const Scene& scene, const Material& material) {
    const MaterialClass c = classOf(scene, material);
    return {c.onFlat != Reflector::none, c.onCurved != Reflector::none};
}

// What a preset spends on rays; see RayScene.
struct RayDensity {
    float leastShare;
    std::uint32_t stride, finest;
    float contrast, contrastNextTo, contrastBetween;
};
RayDensity densityOf(Preset preset) {
    switch (preset) {
        case Preset::draft:
            return {0.01f, 4, 2, 0.1f, 0.1f, 0.8f};
        case Preset::standard:
            return {0.004f, 4, 1, 0.03f, 0.1f, 0.0f};
        case Preset::fine:
            return {0.001f, 1, 1, 0.0f, 0.0f, 0.0f};
    }
    return {0.001f, 1, 1, 0.0f, 0.0f, 0.0f};
}

// Relative to the instance's node, so that distance from the origin costs no precision.
std::vector<std::uint8_t> lightsOf(const Stage& stage, const Instance& instance) {
    glm::dmat4 fromNode = stage.pose.worldFromNode[instance.node];
    const glm::dvec3 origin(fromNode[3]);
    fromNode[3] = {0.0, 0.0, 0.0, 1.0};
    const Bounds& bounds = boundsOf(stage.pose, stage.scene.meshes[instance.mesh]);
    return allLightsReaching(stage.lights, origin, transformed(bounds, fromNode));
}

// Moves the draws that have rays from `draws` to `recorded`.
void record(std::vector<Draw>& draws, RecordedDraws& recorded) {
    const auto first = std::stable_partition(draws.begin(), draws.end(),
                                             [](const Draw& draw) { return !followsRays(draw); });
    recorded.draws.assign(first, draws.end());
    draws.erase(first, draws.end());
}

std::string reasonOf(const Accuracy& accuracy) {
    std::string reason = "rays of mirrors and glass, followed on the processor";
    const auto add = [&](std::uint32_t paths, const char* of) {
        if (paths > 1) reason += of + std::to_string(paths) + " paths each";
    };
    add(accuracy.raySamples, "; rough mirrors by ");
    add(accuracy.glassRaySamples, "; rough glass by ");
    return reason;
}

class RecordingPasses {
public:
    RecordingPasses(ViewContext& context, const ViewTask& task) : context_(context), task_(task) {}

    void add(Pass pass, DrawScene work) {
        record(work.opaqueDraws, work.recorded);
        addDrawn(std::move(pass), std::move(work));
    }
    void add(Pass pass, DrawGlass work) {
        record(work.glassDraws, work.recorded);
        addDrawn(std::move(pass), std::move(work));
    }

private:
    template <class Work>
    void addDrawn(Pass pass, Work work) {
        const std::vector<Draw> blended = std::move(work.blendedDraws);
        work.blendedDraws.clear();
        const DrawBlended bare{.face = work.face,
                               .view = work.view,
                               .map = work.map,
                               .environment = work.environment,
                               .background = work.background,
                               .reflections = work.reflections};
        addRecording(pass, std::move(work));
        // A draw covers the light of the rays behind it, so rays are added before the next draw.
        DrawBlended next = bare;
        for (std::size_t i = 0; i < blended.size(); ++i) {
            const bool rays = followsRays(blended[i]);
            (rays ? next.recorded.draws : next.draws).push_back(blended[i]);
            if (!rays && i + 1 < blended.size()) continue;
            Pass over = pass;
            over.name = nameOf(task_.subject) + ":blended";
            over.reason = "blended surfaces over the light of rays";
            addRecording(std::move(over), std::move(next));
            next = bare;
        }
    }

    template <class Work>
    void addRecording(Pass pass, Work work) {
        if (work.recorded.draws.empty()) {
            pass.work = std::move(work);
            context_.builder.addPass(std::move(pass));
            return;
        }
        const bool glass = std::any_of(
            work.recorded.draws.begin(), work.recorded.draws.end(),
            [](const Draw& draw) { return (draw.features & FEATURE_TRACED_GLASS) != 0; });
        work.recorded.targets = recordTargets(pass.target, glass ? 4 : 2);
        const TargetSpec& drawn = context_.builder.target(pass.target);
        work.recorded.rect =
            touchedPixels(coveredBy(work.recorded.draws, work.view, context_.stage), drawn.width,
                          drawn.height, 2.0);
        FollowRays rays{.face = work.face,
                        .view = work.view,
                        .map = work.map,
                        .environment = work.environment,
                        .background = work.background,
                        .records = work.recorded.targets,
                        .rect = work.recorded.rect,
                        .radiance = scratchFor(pass.target, "radiance of rays", Format::rgba32f),
                        .everyPixel = glass && work.background.radiance.has_value()};
        Pass follow{.name = nameOf(task_.subject) + ":rays",
                    .subject = task_.subject,
                    .effect = glass ? Effect::refraction : Effect::environmentReflection,
                    .generation = pass.generation,
                    .target = pass.target,
                    .reason = reasonOf(context_.stage.settings.accuracy),
                    .work = std::move(rays)};
        pass.work = std::move(work);
        context_.builder.addPass(std::move(pass));
        context_.builder.addPass(std::move(follow));
    }

    // As large as `target`. All views share it: what a pass writes there, the next one reads.
    // number: of those with this name.
    TargetId scratchFor(TargetId target, const char* name, Format format,
                        std::uint32_t number = 0) {
        const TargetSpec drawn = context_.builder.target(target);
        PlanHash key;
        key.add(name);
        key.add(number);
        if (const auto shared = context_.builder.shared(key.value())) {
            context_.builder.enlarge(*shared, drawn.width, drawn.height);
            return *shared;
        }
        const TargetId added = context_.builder.addTarget({.name = name,
                                                           .format = format,
                                                           .width = drawn.width,
                                                           .height = drawn.height,
                                                           .scratch = true});
        context_.builder.share(key.value(), added);
        return added;
    }
    std::vector<TargetId> recordTargets(TargetId target, std::uint32_t count) {
        std::vector<TargetId> targets;
        for (std::uint32_t i = 0; i < count; ++i) {
            targets.push_back(scratchFor(target, "records of rays", Format::rgba32ui, i));
        }
        return targets;
    }

    ViewContext& context_;
    const ViewTask& task_;
};

// Such a driver has 32 samplers for a fragment shader, and one that traces rays has 24 others.
constexpr int kLayerMapsWithRays = 8;
// What shows most comes first.
constexpr Features kLayerMaps[] = {LAYER_CLEARCOAT_NORMAL_MAP,
                                   LAYER_CLEARCOAT_MAP,
                                   LAYER_SHEEN_COLOR_MAP,
                                   LAYER_IRIDESCENCE_MAP,
                                   LAYER_IRIDESCENCE_THICKNESS_MAP,
                                   LAYER_SPECULAR_COLOR_MAP,
                                   LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP,
                                   LAYER_DIFFUSE_TRANSMISSION_MAP,
                                   LAYER_CLEARCOAT_ROUGHNESS_MAP,
                                   LAYER_ANISOTROPY_MAP,
                                   LAYER_SPECULAR_MAP,
                                   LAYER_SHEEN_ROUGHNESS_MAP};

}  // namespace

Features withoutExcessMaps(Features features) {
    int maps = 0;
    for (const Features map : kLayerMaps) {
        const Features bit = ofLayers(map);
        if ((features & bit) != 0 && ++maps > kLayerMapsWithRays) features &= ~bit;
    }
    return features;
}

void leaveOutExcessMaps(SeenView& seen) {
    for (SeenSurface& surface : seen.surfaces) {
        if (!(surface.features & (FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS))) continue;
        const Features kept = withoutExcessMaps(surface.features);
        seen.mapsLeftOut += static_cast<std::uint64_t>(std::popcount(surface.features ^ kept));
        surface.features = kept;
    }
}

void addDrawnPass(ViewContext& context, const ViewTask& task, Pass pass) {
    const bool records = context.frame.limits.rays == Rays::processor && followsRays(pass);
    RecordingPasses passes(context, task);
    if (auto* scene = std::get_if<DrawScene>(&pass.work); records && scene) {
        passes.add(pass, *scene);
    } else if (auto* glass = std::get_if<DrawGlass>(&pass.work); records && glass) {
        passes.add(pass, *glass);
    } else {
        context.builder.addPass(std::move(pass));
    }
}

void planRays(FramePlan& plan, const FrameContext& context, const Stage& stage) {
    const bool traces = std::any_of(plan.passes.begin(), plan.passes.end(),
                                    [](const Pass& pass) { return followsRays(pass); });
    if (!traces && !context.needsRays) return;
    RayScene rays;
    rays.materialOfInstance = stage.materials.materialOfInstance;
    rays.hidden = stage.materials.hidden;
    rays.hitFeatures = featuresOfAll(stage);
    rays.bounces = stage.settings.accuracy.bounces;
    const RayDensity density = densityOf(stage.settings.accuracy.preset);
    rays.leastShare = density.leastShare;
    rays.stride = density.stride;
    rays.finest = density.finest;
    rays.contrast = density.contrast;
    rays.contrastNextTo = density.contrastNextTo;
    rays.contrastBetween = density.contrastBetween;
    rays.lobePaths = stage.settings.accuracy.raySamples;
    rays.glassLobePaths = stage.settings.accuracy.glassRaySamples;
    // A ray looks to the centre of a light: soft shadows are in the map.
    rays.shadowRays = stage.settings.accuracy.preset == Preset::fine && plan.shadowSamples == 0;
    for (const Instance& instance : stage.scene.instances) {
        rays.instances.push_back({.lights = lightsOf(stage, instance)});
    }
    for (const Surface& surface : stage.surfaces) {
        rays.instances[surface.instance].glass = surface.glass;
    }
    for (const Material& m : stage.scene.materials) {
        rays.materials.push_back(propertiesOf(stage.scene, m));
    }
    for (const Material& m : plan.materials) {
        rays.materials.push_back(propertiesOf(stage.scene, m));
    }
    plan.rays = std::move(rays);
}

}  // namespace clerestory
