// The renderer in this process, with everything that answers from it: scenes, frames, long jobs.
#pragma once

#include "server/api/backend.h"
#include "server/api/frame_service.h"
#include "server/api/metrics.h"
#include "server/api/renderer_routes.h"
#include "server/api/route_table.h"
#include "server/jobs/budgets.h"
#include "server/jobs/comparisons.h"
#include "server/jobs/jobs.h"
#include "server/queue/render_queue.h"
#include "server/scenes/scene_library.h"

namespace clerestory {

struct LocalBackendOptions {
    RendererOptions renderer;
    FairQueue::Limits queue;
    SceneSources scenes;
    std::shared_ptr<const CurveStore> curves;  // of budgets; null: in memory only
    ServerLimits limits;
    bool signedLinks = false;  // see FrameRoutes
    // That computes light and compiles programs in advance.
    std::shared_ptr<BackgroundWork> work = std::make_shared<BackgroundWork>();
};

class LocalBackend final : public RenderBackend {
public:
    // Returns when the renderer is created; scenes load in the background. Throws
    // std::runtime_error with a one-line message.
    explicit LocalBackend(const LocalBackendOptions& options);

    Answer answer(const Call& call) override;
    std::optional<Problem> refusalFor(const std::string& client) const override;
    EncodedFrame draw(const FrameOrder& order) override;
    SceneReport sceneReport(const std::string& id) override;
    std::shared_ptr<const LoadedScenes> loadedScenes() const override;
    std::optional<WorkerStatus> workerStatus() const override { return std::nullopt; }
    bool importing() const override { return library_.importing(); }
    void stop() override { queue_.refuseNew(); }

    // For the worker process, which reports on both, and for tests.
    RenderQueue& queue() { return queue_; }
    SceneLibrary& library() { return library_; }

    const Routes& routes() const { return routes_; }

private:
    Metrics metrics_;
    RenderQueue queue_;
    SceneLibrary library_;
    Canary canary_;
    const JobResources jobResources_;
    Budgets budgets_;
    Comparisons comparisons_;
    FrameService frames_;
    Routes routes_;
    Jobs jobs_;                       // ends first: its work uses the others
    std::uint64_t rendererHash_ = 0;  // LoadedScenes::renderer
};

}  // namespace clerestory
