#include "plan/effects/background.h"

#include <algorithm>
#include <array>
#include <variant>

namespace clerestory {
namespace {

bool seesGlass(const Stage& stage, const View& view) {
    if (!stage.settings.effects.refraction) return false;
    const SeenView seen = seenFrom(stage, view);
    return std::any_of(seen.surfaces.begin(), seen.surfaces.end(),
                       [](const SeenSurface& s) { return s.surface->glass != Glass::none; });
}

}  // namespace

SeenView planBackground(ViewContext& context, ViewTask root,
                        const std::optional<BackgroundRequest>& background, TargetId& radiance) {
    radiance = root.target;
    if (background && std::holds_alternative<std::array<double, 3>>(*background)) {
        const auto& [r, g, b] = std::get<std::array<double, 3>>(*background);
        root.background.radiance = glm::vec3(r, g, b);
        return planView(context, root);
    }
    if (!isTransparent(background)) return planView(context, root);
    if (!seesGlass(context.stage, root.view)) {
        root.background.coverage = true;
        return planView(context, root);
    }
    root.background.radiance = glm::vec3(0.0f);
    SeenView seen = planView(context, root);

    // The second view makes the same decisions, which are not repeated in the plan.
    const PlanBuilder::Explanations explained = context.builder.explanations();
    TargetSpec spec = context.builder.target(root.target);
    spec.name = "radiance before white";
    ViewTask before = root;
    before.target = context.builder.addTarget(spec);
    before.background.radiance = glm::vec3(1.0f);
    before.reason = "the same view before a white background, for the transmittance of glass";
    planView(context, before);
    context.builder.truncateExplanations(explained);

    spec.name = "radiance with alpha";
    spec.depth = false;
    radiance = context.builder.addTarget(spec);
    BackgroundAlpha alpha;
    alpha.source = root.target;
    alpha.white = before.target;
    context.builder.addPass({.name = "alpha",
                             .target = radiance,
                             .reason = "alpha from the difference of both backgrounds",
                             .work = alpha});
    return seen;
}

void explainBackground(FramePlan& plan, const std::optional<BackgroundRequest>& background) {
    if (!background || *background == BackgroundRequest(Background::map)) return;
    plan.skipped.push_back({"sky", Effect::base,
                            isTransparent(background) ? "the background is transparent"
                                                      : "the request sets the background"});
}

}  // namespace clerestory
