// Warming up: small plans whose execution makes the driver compile every program that frames use.
//
//     WarmUpPlanner planner;
//     FramePlan first = planner.plan(planFrame(...));   // execute each pass once
//     FramePlan second = planner.plan(planFrame(...));  // what the first does not contain
#pragma once

#include "plan/graph/frame_plan.h"

#include <memory>

namespace clerestory {

struct WarmUpPrograms;

class WarmUpPlanner {
public:
    WarmUpPlanner();
    ~WarmUpPlanner();
    WarmUpPlanner(const WarmUpPlanner&) = delete;
    WarmUpPlanner& operator=(const WarmUpPlanner&) = delete;

    // Draws every combination of program, material and pass type of `plan` once, into targets of a
    // few pixels; each program has a separate pass. Leaves out what plans of earlier calls draw.
    // Passes keep their order, but those that follow rays are last. Only prefiltered environment
    // maps are useful results: they have their full size and stay resident.
    FramePlan plan(const FramePlan& plan);

private:
    std::unique_ptr<WarmUpPrograms> planned_;
};

}  // namespace clerestory
