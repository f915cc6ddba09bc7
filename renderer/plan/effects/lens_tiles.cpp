#include "plan/effects/lens_tiles.h"

#include "plan/effects/method_choice.h"

#include <algorithm>

namespace clerestory {
namespace {

double errorOf(const Decision& decision) {
    const auto taken = std::find_if(decision.candidates.begin(), decision.candidates.end(),
                                    [&](const Candidate& c) { return c.method == decision.taken; });
    return taken == decision.candidates.end() ? 0.0 : taken->error;
}

}  // namespace

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
    // The passes of the tiles have the samples and the depth.
    plan.targets[frame.target].samples = 1;
    plan.targets[frame.target].depth = false;
    return tasks;
}

TargetId planAssembly(FramePlan& plan, std::vector<LensTile> tiles,
                      const std::vector<ViewTask>& tasks, const ViewTask& frame) {
    AssembleLens work{.lens = plan.lens->lens, .tiles = std::move(tiles)};
    for (const ViewTask& task : tasks) work.sources.push_back(task.target);
    work.numbers = plan.channel != Channel::color;
    work.depth = plan.channel == Channel::depth;
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
