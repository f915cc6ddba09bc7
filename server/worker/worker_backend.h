// The renderer in worker processes: a supervisor, and what the server remembers of its worker.
#pragma once

#include "server/api/backend.h"
#include "server/worker/job_journal.h"
#include "server/worker/overload_cache.h"
#include "server/worker/supervisor.h"

#include <atomic>

namespace clerestory {

class WorkerBackend final : public RenderBackend {
public:
    // Returns when the first worker is ready. Throws as Supervisor does.
    explicit WorkerBackend(const SupervisorOptions& options) : supervisor_(options) {}

    Answer answer(const Call& call) override;
    std::optional<Problem> refusalFor(const std::string& client) const override;
    EncodedFrame draw(const FrameOrder& order) override;
    SceneReport sceneReport(const std::string& id) override;
    std::optional<WorkerStatus> workerStatus() const override;
    bool importing() const override { return false; }  // a worker's import ends with it
    void stop() override { stopping_ = true; }

    Supervisor& supervisor() { return supervisor_; }

private:
    Supervisor supervisor_;
    OverloadCache overload_;
    JobJournal jobs_;
    std::atomic<bool> stopping_{false};
};

}  // namespace clerestory
