// Carries plans out, top to bottom. Decides nothing.
#pragma once

#include "image/image.h"
#include "passes/health.h"
#include "passes/map_pictures.h"
#include "passes/passes.h"
#include "passes/readback.h"

#include <list>
#include <memory>

namespace clerestory {

// A plan and what it was planned for.
struct ExecutionInput {
    const FramePlan& plan;
    const Scene& scene;  // was uploaded
    const Pose& pose;
    const EnvironmentMap& environment;
    const EnvironmentMaps& maps;
};

struct Execution {
    Image image;
    std::vector<double> passMilliseconds;  // one for each of plan.passes
    double readbackMilliseconds = 0.0;
    std::uint64_t mapBytes = 0;  // that outlive the frame and that it read: cubes, the rays' tables
    std::vector<TexelCounts> health;  // Readback::health: one for each of plan.targets
    std::vector<MapPicture> maps;     // Readback::maps
};

class Executor {
public:
    Execution run(const ExecutionInput& input, Readback readback = Readback::picture);
    // One pass of a plan, for what the driver compiles for it; what it draws is of no use.
    void runAlone(const ExecutionInput& input, std::size_t pass);
    // Resident maps, for the planner.
    ResidentMaps residentMaps() const { return targets_.residentMaps(); }
    // A scene is uploaded before it is drawn; forgetting frees what was uploaded.
    void upload(const std::shared_ptr<const Scene>& scene);
    void forget(const Scene& scene);
    void forgetMaps() { targets_.forgetResident(); }
    // After a frame that failed somewhere within: lets go of everything but the scenes, whose
    // content was complete when they were uploaded. The next frame makes what it needs.
    void recover();
    const DrawCounters& counters() const { return resources_.counters; }

private:
    const GpuEnvironment& uploaded(const EnvironmentMap& map);
    GpuTracer& tracerOf(const Scene& scene, const FramePlan& plan, const Pose& pose);
    std::vector<Target*> begin(const FramePlan& plan);
    void runPass(const ExecutionInput& frame, const Pass& pass,
                 const std::vector<Target*>& targets);
    Image readBack(const FramePlan& plan, const Target& output);

    PassResources resources_;
    TargetPool targets_;
    std::map<const Scene*, GpuScene> scenes_;
    std::map<const Scene*, GpuTracer> tracers_;  // of scenes that a plan has traced
    struct UploadedMap {
        std::uint64_t contentHash;
        GpuEnvironment environment;
    };
    std::list<UploadedMap> maps_;  // last used first
};

}  // namespace clerestory
