// Counting and printing plans.
#include "plan/frame_plan.h"

#include "plan/features.h"

#include <algorithm>

#include <numeric>
#include <sstream>

namespace clerestory {
namespace {

void count(const std::vector<Draw>& draws, PlanTotals& totals) {
    totals.draws += draws.size();
    for (const Draw& draw : draws) totals.triangles += draw.indexCount / 3;
}

}  // namespace

const View* frameView(const FramePlan& plan) {
    const View* view = nullptr;
    for (const Pass& pass : plan.passes) {
        const bool whole = pass.kind == PassKind::surface || pass.kind == PassKind::channel;
        if (whole && !pass.views.empty()) view = &pass.views.front();
    }
    return view;
}

bool traces(const Pass& pass) {
    const auto traced = [](const Draw& draw) {
        return (draw.features & (FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS)) != 0;
    };
    return std::any_of(pass.opaqueDraws.begin(), pass.opaqueDraws.end(), traced) ||
           std::any_of(pass.blendedDraws.begin(), pass.blendedDraws.end(), traced);
}

PlanTotals totals(const Pass& pass) {
    PlanTotals t;
    t.passes = 1;
    t.views = pass.views.size();
    count(pass.depthDraws, t);
    count(pass.opaqueDraws, t);
    count(pass.blendedDraws, t);
    return t;
}

PlanTotals totals(const FramePlan& plan) {
    PlanTotals sum;
    for (const Pass& pass : plan.passes) {
        const PlanTotals t = totals(pass);
        sum.passes += t.passes;
        sum.views += t.views;
        sum.draws += t.draws;
        sum.triangles += t.triangles;
    }
    return sum;
}

std::string_view nameOf(PassKind kind) {
    switch (kind) {
        case PassKind::environment:
            return "environment";
        case PassKind::prefilter:
            return "prefilter";
        case PassKind::gaussian:
            return "gaussian";
        case PassKind::levels:
            return "levels";
        case PassKind::capture:
            return "capture";
        case PassKind::mirror:
            return "mirror";
        case PassKind::surface:
            return "surface";
        case PassKind::backFaces:
            return "backFaces";
        case PassKind::backdrop:
            return "backdrop";
        case PassKind::glass:
            return "glass";
        case PassKind::channel:
            return "channel";
        case PassKind::twirl:
            return "twirl";
        case PassKind::convolve:
            return "convolve";
        case PassKind::glowBright:
            return "glowBright";
        case PassKind::glowDown:
            return "glowDown";
        case PassKind::glowUp:
            return "glowUp";
        case PassKind::glow:
            return "glow";
        case PassKind::toneMap:
            return "toneMap";
        case PassKind::edgeFilter:
            return "edgeFilter";
    }
    return "";
}

std::string_view nameOf(Effect effect) {
    switch (effect) {
        case Effect::base:
            return "base";
        case Effect::emission:
            return "emission";
        case Effect::refraction:
            return "refraction";
        case Effect::planarReflection:
            return "planarReflection";
        case Effect::environmentReflection:
            return "environmentReflection";
        case Effect::filters:
            return "filters";
    }
    return "";
}

std::string_view nameOf(Format format) {
    switch (format) {
        case Format::rgba16f:
            return "rgba16f";
        case Format::rgba32f:
            return "rgba32f";
        case Format::srgba8:
            return "srgba8";
    }
    return "";
}

std::string_view nameOf(Method method) {
    switch (method) {
        case Method::environment:
            return "environment";
        case Method::probe:
            return "probe";
        case Method::mirror:
            return "mirror";
        case Method::backdrop:
            return "backdrop";
        case Method::traced:
            return "traced";
    }
    return "";
}

std::string toText(const FramePlan& plan) {
    std::ostringstream out;
    for (const Pass& pass : plan.passes) {
        const PlanTotals t = totals(pass);
        out << "run   " << pass.name << " (" << nameOf(pass.kind) << ")";
        if (pass.target != kNoTarget) {
            const TargetSpec& target = plan.targets[pass.target];
            out << " -> " << target.width << "x" << target.height << " " << nameOf(target.format);
        }
        if (t.draws > 0) out << ", " << t.draws << " draws, " << t.triangles << " triangles";
        out << ": " << pass.reason << "\n";
    }
    for (const Skipped& skipped : plan.skipped) {
        out << "skip  " << skipped.name << " (" << nameOf(skipped.effect) << "): " << skipped.reason
            << "\n";
    }
    for (const Decision& decision : plan.decisions) {
        out << "take  " << decision.name << " (" << nameOf(decision.effect)
            << "): " << nameOf(decision.taken) << ", " << decision.reason << "\n";
    }
    const PlanTotals t = totals(plan);
    out << "total " << t.passes << " passes, " << t.views << " views, " << t.draws << " draws, "
        << t.triangles << " triangles\n";
    return out.str();
}

}  // namespace clerestory
