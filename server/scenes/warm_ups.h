// Compiles what the first frames of a loaded scene will draw, before anybody asks for them: step by
// step on the renderer's thread, between frames, and where the driver is software at the same time
// on a thread and a context of its own, last step first. Both find in the driver's shader cache
// what the other has compiled. Thread-safe.
#pragma once

#include "server/queue/render_queue.h"
#include "server/scenes/compile_ahead.h"

#include <atomic>
#include <map>
#include <optional>

namespace clerestory {

class WarmUps {
public:
    struct Progress {
        std::size_t done = 0, total = 0;  // programs, about; 0 before it begins
        bool finished = false;            // on both threads
    };

    WarmUps(RenderQueue& queue, const RendererOptions& options);
    ~WarmUps();
    WarmUps(const WarmUps&) = delete;
    WarmUps& operator=(const WarmUps&) = delete;

    // Whether begin() may have use for a copy of this scene.
    static bool wantsCopy(const Scene& scene);
    // After the scene was given to the renderer. `scene` needs no vertices and no texels; `copy`
    // is for the second thread, with vertices and without texels, where wantsCopy(). `whenFinished`
    // is called on the renderer's thread.
    void begin(const Scene& scene, std::optional<Scene> copy,
               std::vector<std::shared_ptr<const EnvironmentMap>> maps,
               std::function<void()> whenFinished);
    // After the scene was taken from the renderer.
    void forget(const std::string& scene);
    Progress of(const std::string& scene) const;

private:
    struct Task;
    static void advance(Task& task, Renderer& renderer);

    RenderQueue& queue_;
    const RendererOptions options_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Task>> tasks_;  // by scene, the last of each
    // The renderer's thread may outlive this.
    std::shared_ptr<std::atomic<bool>> ending_ = std::make_shared<std::atomic<bool>>(false);
    std::unique_ptr<CompileAhead> ahead_;  // of one scene at a time
    std::weak_ptr<Task> aheadOf_;
};

}  // namespace clerestory
