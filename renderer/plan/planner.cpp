// The walk over what a frame could need, and the reasons.
#include "plan/planner.h"

#include "plan/draws.h"
#include "plan/lighting.h"
#include "plan/view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

std::string format(const char* pattern, double value) {
    char text[160];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

TargetId addTarget(FramePlan& plan, TargetSpec spec) {
    plan.targets.push_back(std::move(spec));
    return static_cast<TargetId>(plan.targets.size() - 1);
}

// Mixes numbers into a key (the finaliser of splitmix64).
std::uint64_t mixed(std::uint64_t key, std::uint64_t value) {
    key ^= value + 0x9e3779b97f4a7c15ull + (key << 6) + (key >> 2);
    key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ull;
    key = (key ^ (key >> 27)) * 0x94d049bb133111ebull;
    return key ^ (key >> 31);
}

// Down to faces of 4 texels: fewer hold no more than the harmonics do.
std::uint32_t roughnessLevels(std::uint32_t faceSize) {
    const auto full = static_cast<std::uint32_t>(std::bit_width(faceSize));
    return full > 3 ? full - 2 : 1;
}

TargetId planEnvironment(FramePlan& plan, const FrameRequest& request,
                         const EnvironmentMap& environment, const ResidentMaps& resident) {
    const Accuracy& a = request.accuracy;
    const std::uint64_t key = std::max<std::uint64_t>(
        1, mixed(mixed(environment.contentHash, a.environmentSize), a.environmentSamples));
    const TargetId target = addTarget(plan, {.name = "environment:" + environment.name,
                                             .kind = TargetKind::cube,
                                             .format = Format::rgba16f,
                                             .width = a.environmentSize,
                                             .height = a.environmentSize,
                                             .levels = roughnessLevels(a.environmentSize),
                                             .residentKey = key});
    if (resident.keys.contains(key)) {
        plan.skipped.push_back({plan.targets[target].name, Effect::base, "resident and unchanged"});
    } else {
        plan.passes.push_back({.kind = PassKind::environment,
                               .name = plan.targets[target].name,
                               .target = target,
                               .reason = "lights the scene and is not resident at this accuracy"});
    }
    return target;
}

void explainEffects(FramePlan& plan, const FrameRequest& request, const ViewDraws& draws) {
    const auto skip = [&](const char* name, Effect effect, std::string reason) {
        plan.skipped.push_back({name, effect, std::move(reason)});
    };
    if (!draws.emissiveInScene)
        skip("emission", Effect::emission, "the scene has no emissive material");
    else if (!request.effects.emission)
        skip("emission", Effect::emission, "switched off");
    else if (!draws.anyEmissive)
        skip("emission", Effect::emission, "no emissive surface in view");

    const auto later = [&](const char* name, Effect effect, bool on) {
        skip(name, effect, on ? "this version draws such surfaces plainly" : "switched off");
    };
    if (draws.glassInScene)
        later("glass", Effect::refraction, request.effects.refraction);
    else
        skip("glass", Effect::refraction, "the scene has no transmissive material");
    later("mirrors", Effect::planarReflection, request.effects.planarReflection);
    later("probes", Effect::environmentReflection, request.effects.environmentReflection);
}

void planSurface(FramePlan& plan, const FrameRequest& request, const View& view, ViewDraws draws,
                 TargetId target, std::vector<TargetId> reads) {
    Pass pass{
        .kind = PassKind::surface, .name = "surface", .target = target, .reads = std::move(reads)};
    pass.views = {view};
    pass.reason =
        draws.depth.empty()
            ? format("the requested view; no depth prepass, %.1f layers predicted", draws.overdraw)
            : format("the requested view; depth first, %.1f layers predicted", draws.overdraw);
    pass.depthDraws = std::move(draws.depth);
    pass.opaqueDraws = std::move(draws.opaque);
    pass.blendedDraws = std::move(draws.blended);
    pass.sky = request.environment.visible;
    if (!pass.sky)
        plan.skipped.push_back({"sky", Effect::base, "the request hides the environment"});
    plan.passes.push_back(std::move(pass));
}

void planChannel(FramePlan& plan, const View& view, ViewDraws draws, TargetId target) {
    Pass pass{.kind = PassKind::channel, .name = "channel", .target = target};
    pass.views = {view};
    pass.reason = "the request asks for numbers instead of colour";
    pass.opaqueDraws = std::move(draws.opaque);
    pass.opaqueDraws.insert(pass.opaqueDraws.end(), draws.blended.begin(), draws.blended.end());
    plan.passes.push_back(std::move(pass));
}

void planDisplay(FramePlan& plan, const FrameRequest& request, TargetId color) {
    const TargetSpec display{.format = Format::srgba8, .width = plan.width, .height = plan.height};
    TargetSpec toneMapped = display;
    toneMapped.name = "display";
    plan.output = addTarget(plan, toneMapped);
    plan.passes.push_back({.kind = PassKind::toneMap,
                           .name = "toneMap",
                           .target = plan.output,
                           .reads = {color},
                           .reason = "radiance becomes display colour"});
    if (!request.accuracy.edgeFilter) {
        plan.skipped.push_back({"edgeFilter", Effect::base, "not asked for at this accuracy"});
        return;
    }
    TargetSpec filtered = display;
    filtered.name = "filtered";
    const TargetId before = plan.output;
    plan.output = addTarget(plan, filtered);
    plan.passes.push_back({.kind = PassKind::edgeFilter,
                           .name = "edgeFilter",
                           .target = plan.output,
                           .reads = {before},
                           .reason = "smooths edges"});
}

}  // namespace

FramePlan planFrame(const Scene& scene, const Pose& pose, const FrameRequest& request,
                    const EnvironmentMap& environment, const ResidentMaps& resident,
                    const DeviceLimits& limits) {
    if (std::vector<FieldError> errors = problems(request); !errors.empty()) {
        throw InvalidRequest(std::move(errors));
    }
    FramePlan plan;
    plan.width = request.width;
    plan.height = request.height;
    plan.channel = request.output.channel;
    plan.toneMap = request.toneMap;
    plan.exposureFactor = static_cast<float>(std::exp2(request.exposure));
    plan.anisotropy = std::min(request.accuracy.anisotropy, std::max(1u, limits.maxAnisotropy));
    plan.environment = environment.name;
    plan.environmentIntensity = static_cast<float>(request.environment.intensity);
    plan.environmentSamples = request.accuracy.environmentSamples;
    const auto& [x, y, z, w] = request.environment.rotation;
    const glm::dmat3 worldFromMap = glm::mat3_cast(glm::normalize(glm::dquat(w, x, y, z)));
    plan.mapFromWorld = glm::transpose(worldFromMap);

    const View view = requestedView(request.camera, scene, pose, request.width, request.height);
    const bool color = request.output.channel == Channel::color;
    if (color) {
        plan.lights =
            placedLights(scene, pose, environment, worldFromMap, plan.environmentIntensity);
    }
    ViewDraws draws = drawsFor(scene, pose, view, request.effects, plan.lights);
    if (draws.culled > 0) {
        plan.skipped.push_back({"clusters", Effect::base,
                                std::to_string(draws.culled) + " of " +
                                    std::to_string(draws.clusters) +
                                    " clusters are outside the view"});
    }
    if (draws.mostLights > kMaxLightsPerDraw) {
        plan.skipped.push_back({"lights", Effect::base,
                                std::to_string(draws.mostLights) +
                                    " lights reach one draw; the strongest " +
                                    std::to_string(kMaxLightsPerDraw) + " are used"});
    }

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
    if (!color) {
        plan.output = addTarget(plan, std::move(main));
        planChannel(plan, view, std::move(draws), plan.output);
        return plan;
    }

    explainEffects(plan, request, draws);
    std::vector<TargetId> reads;
    if (draws.anyLit && plan.environmentIntensity > 0.0f) {
        reads.push_back(planEnvironment(plan, request, environment, resident));
    } else {
        plan.skipped.push_back({"environment:" + environment.name, Effect::base,
                                draws.anyLit ? "its intensity is 0" : "nothing in view is lit"});
    }
    const TargetId radiance = addTarget(plan, std::move(main));
    planSurface(plan, request, view, std::move(draws), radiance, std::move(reads));
    if (floats) {
        plan.output = radiance;
        plan.skipped.push_back({"toneMap", Effect::base, "the request asks for linear radiance"});
    } else {
        planDisplay(plan, request, radiance);
    }
    return plan;
}

}  // namespace clerestory
