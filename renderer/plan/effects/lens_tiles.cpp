#include "plan/effects/lens_tiles.h"

#include "plan/effects/method_choice.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

double errorOf(const Decision& decision) {
    const auto taken = std::find_if(decision.candidates.begin(), decision.candidates.end(),
                                    [&](const Candidate& c) { return c.method == decision.taken; });
    return taken == decision.candidates.end() ? 0.0 : taken->error;
}

}  // namespace

View viewOf(const LensTile& tile, const Lens& lens, const View& frame) {
    View view = frame;
    const glm::dmat3 viewFromWorld =
        glm::transpose(tile.cameraFromTile) * glm::dmat3(frame.viewFromWorld);
    view.viewFromWorld = glm::dmat4(viewFromWorld);
    view.viewFromWorld[3] = glm::dvec4(-(viewFromWorld * frame.eye), 1.0);
    const double depth = frame.clipFromView[2][2];  // znear / (zfar - znear); see setDepth()
    std::optional<double> zfar;
    if (depth > 0.0) zfar = frame.znear * (1.0 + 1.0 / depth);
    // The near plane clips nothing that is farther away than znear in any direction.
    if (!std::holds_alternative<PerspectiveLens>(lens.model)) {
        const Intrinsics& i = tile.pinhole;
        const glm::dvec2 farthest(std::max(i.cx, tile.width - i.cx) / i.fx,
                                  std::max(i.cy, tile.height - i.cy) / i.fy);
        view.znear /= std::sqrt(1.0 + glm::dot(farthest, farthest));
    }
    view.clipFromView = perspective(tile.pinhole, tile.width, tile.height, view.znear, zfar);
    return view;
}

double tileDensity(Preset preset) {
    switch (preset) {
        case Preset::draft:
            return 1.0;
        case Preset::standard:
            return 1.5;
        case Preset::fine:
            return 2.0;
    }
    return 1.0;
}

std::vector<ViewTask> tileTasks(FramePlan& plan, const std::vector<LensTile>& tiles,
                                const ViewTask& frame) {
    const TargetSpec whole = plan.targets[frame.target];
    std::vector<ViewTask> tasks;
    for (const LensTile& tile : tiles) {
        TargetSpec spec = whole;
        spec.name = "tile:" + tile.name;
        spec.width = tile.width;
        spec.height = tile.height;
        ViewTask task = frame;
        task.subject.name = tile.name;
        task.reason = "view " + std::to_string(tasks.size() + 1) + " of " +
                      std::to_string(tiles.size()) + " of the lens " +
                      std::string(typeOf(plan.lens->lens.model)) + ", " +
                      percentOfFrame(tile.share);
        task.view = viewOf(tile, plan.lens->lens, frame.view);
        task.width = tile.width;
        task.height = tile.height;
        task.part = tile.share;
        task.target = PlanBuilder(plan).addTarget(std::move(spec));
        tasks.push_back(std::move(task));
    }
    // The passes of the tiles have the depth.
    plan.targets[frame.target].depth = false;
    return tasks;
}

TargetId planAssembly(FramePlan& plan, std::vector<LensTile> tiles,
                      const std::vector<ViewTask>& tasks, const ViewTask& frame) {
    AssembleLens work{.lens = plan.lens->lens, .tiles = std::move(tiles)};
    for (const ViewTask& task : tasks) work.sources.push_back(task.target);
    work.numbers = plan.channel != Channel::color;
    work.depth = plan.channel == Channel::depth && plan.layer == OutputLayer::direct;
    plan.passes.push_back({.name = "lens",
                           .target = frame.target,
                           .reason = "the lens " + std::string(typeOf(plan.lens->lens.model)) +
                                     " from " + std::to_string(tasks.size()) + " views",
                           .work = std::move(work)});
    return frame.target;
}

std::map<std::string, Method> agreedMethods(const std::vector<Decision>& decisions) {
    struct Choice {
        Method method;
        double error;
        bool differs = false;
    };
    std::map<std::string, Choice> choices;
    for (const Decision& decision : decisions) {
        const double error = errorOf(decision);
        const auto [it, isNew] =
            choices.try_emplace(nameOf(decision.subject), Choice{decision.taken, error});
        if (isNew || it->second.method == decision.taken) continue;
        it->second.differs = true;
        if (error < it->second.error) it->second = {decision.taken, error, true};
    }
    std::map<std::string, Method> agreed;
    for (const auto& [name, choice] : choices) {
        if (choice.differs) agreed.emplace(name, choice.method);
    }
    return agreed;
}

}  // namespace clerestory
