// Executes plans directly, so that tests can change them first and draw with their own programs.
#pragma once

#include "gl/context.h"
#include "passes/executor.h"
#include "passes/gpu_tracer.h"
#include "plan/planner.h"

#include <memory>
#include <string>

namespace clerestory::test {

class PlanRunner {
public:
    PlanRunner();

    // Uploads it, and reads its texture sizes from it later.
    void show(Scene scene);
    const Scene& scene() const { return *scene_; }

    FramePlan plan(const FrameRequest& request) const;
    Image run(const FramePlan& plan);
    const std::vector<double>& passMilliseconds() const { return passMilliseconds_; }
    // One ray for each pixel of a channel plan: what the channel pass would have drawn. Reports how
    // long the last of `rounds` took.
    Image traced(const FramePlan& plan, int rounds = 1, double* milliseconds = nullptr);

    const EnvironmentMap& environment() const { return environment_; }

private:
    gl::Context context_;
    Executor executor_;
    PassResources resources_;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<GpuScene> gpuScene_;
    std::unique_ptr<GpuTracer> tracer_;
    std::vector<double> passMilliseconds_;  // of the last run
    Pose pose_;
    EnvironmentMap environment_;
};

// Whether a pass of the plan follows rays.
bool tracesAnything(const FramePlan& plan);

// One for all tests of a program.
PlanRunner& workbench();

}  // namespace clerestory::test
