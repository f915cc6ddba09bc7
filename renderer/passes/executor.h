// Executes plans, pass by pass. Makes no decisions. One per renderer, on the thread of its context.
#pragma once

#include "image/image.h"
#include "light/bake.h"
#include "passes/passes.h"
#include "passes/readback.h"

#include <functional>
#include <list>
#include <memory>
#include <set>
#include <span>

namespace clerestory {

// A plan and the values from which it was made.
struct ExecutionInput {
    const FramePlan& plan;
    const Scene& scene;  // uploaded
    const Pose& pose;
    const EnvironmentMap& environment;
    const EnvironmentMaps& maps;
    // Light at the vertices of `scene`, or null. Must stay as it is while the executor draws with
    // it.
    std::shared_ptr<const light::SurfaceLight> surfaceLight = nullptr;
    const Pose* flowPose = nullptr;  // as FrameContext::flowPose
};

struct Execution {
    bool abandoned = false;  // the other members describe the passes that were executed
    Image image;
    std::vector<double> passMilliseconds;  // one for each of plan.passes
    std::vector<std::uint64_t> passPaths;  // the same: paths of rays followed on the processor
    double readbackMilliseconds = 0.0;
    std::uint64_t mapBytes = 0;  // resident data that the frame uses: cubes, tables for ray tracing
    std::vector<TexelCounts> health;        // Readback::health: one for each of plan.targets
    std::vector<MapPicture> maps;           // Readback::maps
    std::vector<InstanceExtent> instances;  // of the channel instances
};

class Executor {
public:
    // `abandoned` is called before each pass and within long ones. Once it returns true the frame
    // ends; maps that are complete by then stay resident.
    Execution run(const ExecutionInput& input, Readback readback = Readback::picture,
                  const std::function<bool()>& abandoned = {});
    // Executes one pass of a plan so that the driver compiles it; the picture is not used.
    void runAlone(const ExecutionInput& input, std::size_t pass);
    // Resident maps, for the planner.
    ResidentMaps residentMaps() const { return targets_.residentMaps(); }
    // A scene must be uploaded before it is drawn; forget() frees its GPU memory. upload() throws
    // if the driver fails.
    // `texturesOf`: uploaded scenes with the images of this one, one after another, whose textures
    // it shares; or none. afterImage: called with the number of each image of its own once its
    // texels are not needed any more.
    void upload(const std::shared_ptr<const Scene>& scene,
                std::span<const Scene* const> texturesOf = {},
                const std::function<void(std::size_t)>& afterImage = {});
    // The tables of a bake (light/bake.h) for a plan with rays.
    void addTables(const ExecutionInput& input, light::BakeInput& bake);
    void forget(const Scene& scene);
    // Frees the tables for rays and the light of a scene that is not shown for now. A frame that
    // needs them makes them again.
    void forgetTables(const Scene& scene);
    // Frees what frames leave for the next one to reuse, apart from resident maps, and the tables
    // of scenes that no run() has shown.
    void releaseScratch();
    void releasePrograms();  // frames make theirs again
    // Whether run() has drawn a frame of it.
    bool hasShown(const Scene& scene) const { return shown_.contains(&scene); }
    // Whether it is uploaded.
    bool holds(const Scene& scene) const { return scenes_.contains(&scene); }
    void forgetMaps() { targets_.forgetResident(); }
    void forgetMaps(const Scene& scene) { targets_.forgetResident(scene); }
    // After a failed frame: releases everything except uploaded scenes, which are complete. The
    // next frame recreates what it needs.
    void recover();
    const DrawCounters& counters() const { return resources_.counters; }

private:
    const GpuEnvironment& uploaded(const EnvironmentMap& map);
    const gl::BufferTexture& uploaded(const std::shared_ptr<const light::SurfaceLight>& light);
    ProcessorTracer& processorTracerOf(std::map<const Scene*, ProcessorTracer>& tracers,
                                       const Scene& scene, const FramePlan& plan, const Pose& pose);
    GpuTracer& tracerOf(const Scene& scene, const FramePlan& plan, const Pose& pose);
    std::vector<Target*> begin(const ExecutionInput& input);
    // sampled: null for all pixels.
    void runPass(const ExecutionInput& frame, const Pass& pass, const std::vector<Target*>& targets,
                 const std::function<bool()>& abandoned, const SampledPixels* sampled = nullptr);
    Image readBack(const FramePlan& plan, const Target& output);

    PassResources resources_;
    TargetPool targets_;
    std::uint64_t frames_ = 0;  // begun
    std::map<const Scene*, GpuScene> scenes_;
    std::set<const Scene*> shown_;  // those of run()
    // Of scenes that a plan traced rays in.
    std::map<const Scene*, GpuTracer> tracers_;
    std::map<const Scene*, ProcessorTracer> processorTracers_;
    std::map<const Scene*, ProcessorTracer> flowTracers_;  // of ExecutionInput::flowPose
    struct UploadedMap {
        std::uint64_t contentHash;
        GpuEnvironment environment;
    };
    std::list<UploadedMap> maps_;  // last used first
    struct UploadedLight {
        std::shared_ptr<const light::SurfaceLight> light;
        gl::Buffer values;
        gl::BufferTexture texture{values, gl::BufferFormat::rgba32ui};
    };
    std::list<UploadedLight> lights_;             // last used first
    std::vector<light::LightValue> movingLight_;  // of the present frame; see lightOfMoving()
    void moveLight(const ExecutionInput& frame);
    void forgetOutdatedLights();  // those that the renderer no longer holds
};

}  // namespace clerestory
