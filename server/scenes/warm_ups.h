// Compiles the shaders of the first frames of a loaded scene in advance: step by step on the
// renderer's thread between frames, and with a software driver also on a second thread
// (compile_ahead.h). After them, if the driver is software, those of frames from around the default
// view. Thread-safe.
#pragma once

#include "server/base/background_work.h"
#include "server/queue/render_queue.h"
#include "server/scenes/compile_ahead.h"

#include <atomic>
#include <map>
#include <optional>

namespace clerestory {

class WarmUps {
public:
    struct Progress {
        std::size_t done = 0, total = 0;  // programs, approximately; 0 before the start
        bool finished = false;            // with the first frames, on both threads
    };

    WarmUps(RenderQueue& queue, const RendererOptions& options,
            std::shared_ptr<BackgroundWork> work);
    ~WarmUps();
    WarmUps(const WarmUps&) = delete;
    WarmUps& operator=(const WarmUps&) = delete;

    // Whether begin() needs a copy of this scene.
    static bool needsCopy(const Scene& scene);
    // Call after the scene was added to the renderer. `scene` needs no vertices and no texels;
    // `copy`, for the second thread if needsCopy(), needs vertices. `whenFinished` is called on the
    // renderer's thread.
    void begin(const Scene& scene, std::optional<Scene> copy,
               std::vector<std::shared_ptr<const EnvironmentMap>> maps,
               std::function<void()> whenFinished);
    // Call after the scene was removed from the renderer.
    void forget(const std::string& scene);
    Progress of(const std::string& scene) const;

private:
    struct Task;
    static bool advance(Task& task, Renderer& renderer);

    RenderQueue& queue_;
    const RendererOptions options_;
    const std::shared_ptr<BackgroundWork> work_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Task>> tasks_;  // by scene
    // Shared, since the renderer's thread may outlive this.
    std::shared_ptr<std::atomic<bool>> ending_ = std::make_shared<std::atomic<bool>>(false);
    std::unique_ptr<CompileAhead> ahead_;  // for one scene at a time
    std::weak_ptr<Task> aheadOf_;
};

}  // namespace clerestory
