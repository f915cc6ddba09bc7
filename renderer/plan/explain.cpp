#include "plan/explain.h"

#include <algorithm>

namespace clerestory {
namespace {

// For each effect: no surface needs it, it is switched off, or none of its surfaces is in view.
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
    const auto explain = [&](const char* name, Effect effect, bool on, const char* absent,
                             const char* outsideView, auto&& is) {
        if (!anywhere(is))
            skip(name, effect, absent);
        else if (!on)
            skip(name, effect, "switched off");
        else if (!inView(is))
            skip(name, effect, outsideView);
    };
    const Effects& on = stage.settings.effects;
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

void explainView(FramePlan& plan, const Stage& stage, const SeenView& seen) {
    const auto skip = [&](const char* name, std::string reason) {
        plan.skipped.push_back({name, Effect::base, std::move(reason)});
    };
    if (seen.culled > 0) {
        skip("clusters", std::to_string(seen.culled) + " of " + std::to_string(seen.clusters) +
                             " clusters are outside the view");
    }
    if (seen.maxLights > kMaxLightsPerDraw) {
        skip("lights", std::to_string(seen.maxLights) + " lights reach one draw; the strongest " +
                           std::to_string(kMaxLightsPerDraw) + " are used");
    }
    if (seen.mapsLeftOut > 0) {
        skip("materialLayers",
             std::to_string(seen.mapsLeftOut) +
                 " textures of layers are left out: a program that traces rays reads at most 8");
    }
    if (!stage.settings.skyVisible) skip("sky", "the request hides the environment");
    if (!seen.anyLit || plan.environmentIntensity <= 0.0f) {
        const Subject map{Subject::Kind::environment, plan.environment};
        plan.skipped.push_back({nameOf(map), Effect::base,
                                seen.anyLit ? "its intensity is 0" : "nothing in view is lit",
                                map});
    }
}

// Rays and shadow maps handle triangles only.
void explainLinesAndPoints(FramePlan& plan, const Stage& stage) {
    const bool any = std::any_of(
        stage.scene.instances.begin(), stage.scene.instances.end(), [&](const Instance& instance) {
            return stage.scene.meshes[instance.mesh].primitive != Primitive::triangles;
        });
    const bool traced =
        std::any_of(plan.decisions.begin(), plan.decisions.end(),
                    [](const Decision& decision) { return decision.taken == Method::traced; });
    const auto skip = [&](Effect effect, const char* reason) {
        plan.skipped.push_back({"linesAndPoints", effect, reason});
    };
    if (any && traced)
        skip(Effect::base, "rays do not meet lines and points: what is ray traced omits them");
    if (any && plan.shadowMap != kNoTarget)
        skip(Effect::shadows, "lines and points cast no shadows");
}

}  // namespace

void explainOmissions(FramePlan& plan, const Stage& stage, const SeenView& seen) {
    explainView(plan, stage, seen);
    explainEffects(plan, stage, seen);
    explainLinesAndPoints(plan, stage);
}

}  // namespace clerestory
