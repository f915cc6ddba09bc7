#include "plan/graph/view_bits.h"

#include "plan/graph/features.h"

#include <algorithm>

namespace clerestory {
namespace {

std::uint32_t kindOfShadows(const FramePlan& plan) {
    const auto all = [&](LightShadow::Kind kind) {
        return std::all_of(plan.lights.begin(), plan.lights.end(), [&](const PlacedLight& light) {
            return !light.shadow || light.shadow->kind == kind;
        });
    };
    return all(LightShadow::Kind::one)   ? VIEW_SHADOWS_ONE
           : all(LightShadow::Kind::six) ? VIEW_SHADOWS_SIX
                                         : 0;
}

}  // namespace

std::uint32_t viewBits(const FramePlan& plan, const View& view, bool coverage, bool surfaceLight) {
    const std::vector<PlacedLight>& lights = plan.lights;
    std::uint32_t bits = 0;
    if (view.orthographic) bits |= VIEW_ORTHOGRAPHIC;
    if (coverage) bits |= VIEW_COVERAGE;
    if (plan.fewPrograms) bits |= VIEW_SHARED_PROGRAMS;
    if (surfaceLight) bits |= VIEW_SURFACE_LIGHT;
    if (surfaceLight && plan.emitters) bits |= VIEW_EMITTERS;
    if (hasRoundLight(lights)) bits |= VIEW_ROUND_LIGHTS;
    if (plan.shadowMap != kNoTarget) bits |= VIEW_SHADOWS | kindOfShadows(plan);
    const bool nearer = std::any_of(lights.begin(), lights.end(), [](const PlacedLight& light) {
        return light.shadow && !light.shadow->nearer.empty();
    });
    if (nearer) bits |= VIEW_SHADOWS_NEAR;
    if (plan.shadowSamples > 0) bits |= VIEW_SHADOWS_SOFT;
    if (plan.shadowTints != kNoTarget) bits |= VIEW_SHADOWS_TINTED;
    if (lights.size() == 1 && lights.front().kind == LightKind::directional) {
        return bits | VIEW_SUN_ONLY;
    }
    // Without a limit they reach every draw, whose list is then the first of the table.
    const bool limited = std::any_of(lights.begin(), lights.end(), [](const PlacedLight& light) {
        return light.kind == LightKind::spot || light.range > 0.0f;
    });
    if (!limited && lights.size() <= VIEW_LIGHTS_MASK) {
        bits |= static_cast<std::uint32_t>(lights.size()) << VIEW_LIGHTS_SHIFT;
    }
    return bits;
}

}  // namespace clerestory
