// What a renderer consists of; for the files of renderer.h only.
#pragma once

#include "compositions.h"
#include "gl/context.h"
#include "passes/executor.h"
#include "plan/effects/surface_light.h"
#include "plan/planner.h"
#include "renderer.h"
#include "scene_lights.h"

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

struct Renderer::State {
    explicit State(const RendererOptions& options);

    // The objects that a request names. subjectOf() throws InvalidRequest for unknown ones.
    struct Subject {
        std::shared_ptr<const Scene> scene;
        std::uint64_t generation;
        std::shared_ptr<const EnvironmentMap> environment;
        std::shared_ptr<const Pose> pose;
        bool convex = false;
        // With computed light of surfaces, `scene` and `pose` are those of its refined meshes.
        std::shared_ptr<const light::SurfaceLight> light = nullptr;
        bool lightFailed = false;
        std::shared_ptr<const Pose> flowPose = nullptr;  // of the channel flow
    };
    FrameContext contextOf(const Subject& subject, const ResidentMaps& resident) const {
        return {.scene = *subject.scene,
                .pose = *subject.pose,
                .environment = *subject.environment,
                .maps = environments,
                .resident = resident,
                .limits = limits,
                .surfaceLight = subject.light ? hashOf(*subject.light) : 0,
                .light = subject.light ? LightProgress{subject.light->revision,
                                                       subject.light->share, subject.lightFailed}
                                       : LightProgress{},
                .flowPose = subject.flowPose.get(),
                .convex = subject.convex};
    }
    static std::uint64_t hashOf(const light::SurfaceLight& light) {
        return light.key * 0x9e3779b97f4a7c15ull + light.revision + 1;
    }
    // What the light of surfaces depends on that the request shows; nothing if it needs none.
    std::optional<LightInputs> lightOf(const Subject& subject, const FrameRequest& request) const;
    // Reads it from disk unless it is known. Returns false if it is neither known nor stored.
    bool findLight(const Subject& subject, const LightInputs& inputs);
    // Begins to compute it, otherwise.
    void beginLight(Subject subject, const FrameRequest& request, LightInputs inputs);
    // Changes the subject to one with that light as far as it is computed, else with that of the
    // open environment.
    void addLight(Subject& subject, const FrameRequest& request, const LightInputs& inputs);
    // Finds it or notes that it is needed, and shows it. Returns Frame::lightNow.
    std::function<LightProgress()> showLight(Subject& subject, const FrameRequest& request);
    // Begins to compute those that showLight() noted: their tables take longer than a frame.
    void beginNeededLights();
    // All views, passes and frames of one time share a pose.
    std::shared_ptr<const Pose> poseOf(const std::shared_ptr<const Scene>& scene,
                                       std::vector<Index> clips, double time) const;
    Subject subjectOf(const FrameRequest& request);
    bool hasEnvironment(const std::string& name) const;
    std::vector<std::string> environmentNames() const;  // sorted
    std::string environmentList() const;
    FramePlan plan(const Subject& subject, const FrameRequest& request) const {
        const ResidentMaps resident = executor.residentMaps();
        return planFrame(contextOf(subject, resident), request);
    }

    ExecutionInput inputOf(const Subject& subject, const FramePlan& plan) const {
        return {plan,         *subject.scene, *subject.pose,         *subject.environment,
                environments, subject.light,  subject.flowPose.get()};
    }
    // These throw RenderFailed only.
    Execution execute(const Subject& subject, const FramePlan& plan, Readback readback,
                      const std::function<bool()>& abandoned) {
        Execution execution;
        guarded([&] { execution = executor.run(inputOf(subject, plan), readback, abandoned); });
        return execution;
    }
    void compile(const Subject& subject, const FramePlan& plan, std::size_t pass) {
        guarded([&] { executor.runAlone(inputOf(subject, plan), pass); });
    }
    template <class Work>
    void guarded(Work work) {
        std::optional<std::string> failure;
        try {
            work();
        } catch (const std::exception& error) {
            failure = error.what();
        }
        requireContext();
        if (!failure) return;
        executor.recover();
        throw RenderFailed(*failure);
    }
    // Throws RenderFailed when the GPU was reset.
    void requireContext() const {
        if (!context.lost()) return;
        if (onReset) onReset();
        throw RenderFailed("the GPU was reset");
    }
    Frame frame(const FrameRequest& request, Readback readback,
                const std::function<bool()>& abandoned);

    gl::Context context;  // the first member: outlives everything that holds OpenGL objects
    const RendererIdentity& identity;
    DeviceLimits limits;
    std::uint64_t maxShadedSamples;
    std::function<void()> onReset;
    std::function<void(const FramePlan&)> beforeDrawing;
    struct Loaded {
        std::shared_ptr<const Scene> scene;
        std::uint64_t generation = 0;
        bool convex = false;
    };
    std::map<std::string, Loaded> scenes;
    struct NeededLight {
        Subject subject;
        FrameRequest request;
        LightInputs inputs;
    };
    std::vector<NeededLight> neededLights;
    std::uint64_t generations = 0;       // calls of addScene()
    std::set<std::string> toBeCompiled;  // scenes; see Renderer::expectCompilation()
    const Loaded& loaded(const std::string& id, const std::string& pointer) const;
    // The scene of the request before it changes nodes: a loaded one, or several in one.
    std::shared_ptr<const Scene> wholeOf(const FrameRequest& request);
    // Throws RenderFailed. texturesOf: scenes whose textures are those of the new one; none: its
    // own.
    void upload(const std::shared_ptr<Scene>& made, std::span<const Scene* const> texturesOf);
    // Frees what was made for the scene.
    void release(const std::shared_ptr<const Scene>& scene);
    void releaseRefined(const std::vector<std::shared_ptr<const Scene>>& scenes);
    mutable EnvironmentMaps environments;  // built-in maps are created on first use
    std::string firstScene;                // scene of requests that name none
    Executor executor;
    std::uint64_t frames = 0;
    struct Moment {
        std::shared_ptr<const Scene> scene;
        std::vector<Index> clips;
        double time;
        std::shared_ptr<const Pose> pose;
    };
    static constexpr std::size_t kMaxMoments = 4;
    mutable std::list<Moment> moments;  // last used first
    SceneLights lights;
    Compositions compositions;
};

}  // namespace clerestory
