#include "plan/graph/frame_plan.h"

#include <sstream>

namespace clerestory {
namespace {

void count(std::span<const Draw> draws, PlanTotals& totals) {
    totals.draws += draws.size();
    for (const Draw& draw : draws) {
        if (draw.primitive == Primitive::triangles) totals.triangles += draw.indexCount / 3;
    }
}

}  // namespace

const View* frameView(const FramePlan& plan) {
    if (plan.lens) return &plan.lens->view;
    const View* view = nullptr;
    for (const Pass& pass : plan.passes) {
        const auto* scene = std::get_if<DrawScene>(&pass.work);
        const bool whole = (scene && scene->purpose == DrawScene::Purpose::surface) ||
                           std::holds_alternative<DrawChannel>(pass.work);
        if (whole) view = pass.view();
    }
    return view;
}

PlanTotals totals(const Pass& pass) {
    PlanTotals t;
    t.passes = 1;
    t.views = pass.view() ? 1 : 0;
    for (const std::span<const Draw> draws : pass.drawLists()) count(draws, t);
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
        case Method::shadowMap:
            return "shadowMap";
        case Method::unshadowed:
            return "unshadowed";
    }
    return "";
}

std::string toText(const FramePlan& plan) {
    std::ostringstream out;
    for (const Pass& pass : plan.passes) {
        const PlanTotals t = totals(pass);
        out << "run   " << pass.name << " (" << pass.kind() << ")";
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
    if (plan.light) {
        out << "light revision " << plan.light->revision << ", " << 100.0 * plan.light->share
            << " % computed\n";
    }
    const PlanTotals t = totals(plan);
    out << "total " << t.passes << " passes, " << t.views << " views, " << t.draws << " draws, "
        << t.triangles << " triangles\n";
    return out.str();
}

}  // namespace clerestory
