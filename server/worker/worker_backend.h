// The renderer in worker processes: a supervisor, and what the server remembers of its worker.
#pragma once

#include "server/api/backend.h"
#include "server/base/call.h"
#include "server/base/problem.h"
#include "server/base/process.h"
#include "server/worker/renderer_queue.h"
#include "server/worker/supervisor.h"

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace clerestory {

// The jobs that clients started, as the server remembers them. Jobs end with their worker process;
// when a client requests a lost job, it is started again in the next worker, under the same id.
// Thread-safe.
class JobJournal {
public:
    using Ask = std::function<Answer(const Call&)>;

    static constexpr int kMaxRuns = 3;           // of one job; each lost run ended with its worker
    static constexpr std::size_t kMaxJobs = 32;  // remembered: more than a worker keeps

    // Answers any call; `ask` answers it by a worker, whose number is in Answer::worker. Throws
    // what `ask` throws.
    Answer ask(const Call& call, const Ask& ask);

private:
    struct Job {
        std::string id;
        Call call;  // that started it
        std::uint64_t worker = 0;
        int runs = 1;
    };
    void add(const Call& call, const Answer& answer);
    std::optional<Job> find(const std::string& id) const;
    void remove(const std::string& id);
    void countRun(const std::string& id, std::uint64_t worker);
    std::optional<Answer> restart(const Job& job, const Ask& ask);

    mutable std::mutex mutex_;
    std::deque<Job> jobs_;  // oldest first
};

// Remembers for a moment that the render queue of the worker was full, so that the server can
// refuse frames without asking the worker: under overload nearly all requests are refused, and the
// worker needs the processor. Thread-safe; does not block.
class OverloadCache {
public:
    // Frames that the worker finishes for its own use are noticed after this time.
    static constexpr std::chrono::milliseconds kLifetime{100};

    // Call begin() before a request that needs a place in the queue, and end() with its problem, if
    // there was one. A refusal is remembered until another request ends, and only if none ended
    // since its begin().
    using Moment = std::uint64_t;
    Moment begin() const;
    void end(Moment begun, const std::string& client, const std::optional<Problem>& problem,
             Clock::time_point now);

    // The problem with which the client would be refused; empty if that is not certain.
    std::optional<Problem> refusalFor(const std::string& client, Clock::time_point now) const;

private:
    struct Refusal {
        Problem problem;
        Clock::time_point until;
    };
    mutable std::mutex mutex_;
    Moment moment_ = 0;
    std::unordered_map<std::string, Refusal> refusals_;  // by client
};

struct WorkerBackendOptions {
    SupervisorOptions workers;
    // Of the queue before several renderers; one renderer has its own.
    FairQueue::Limits queue;
    double deadlineSeconds = 10.0;  // from a request's arrival to its answer
    bool signedLinks = false;       // see FrameRoutes
};

class WorkerBackend final : public RenderBackend {
public:
    // Returns when the first worker is ready. Throws as Supervisor does.
    explicit WorkerBackend(const WorkerBackendOptions& options);

    Answer answer(const Call& call) override;
    std::optional<Problem> refusalFor(const std::string& client) const override;
    EncodedFrame draw(const FrameOrder& order) override;
    SceneReport sceneReport(const std::string& id) override;
    std::shared_ptr<const LoadedScenes> loadedScenes() const override {
        return supervisor_.loadedScenes();
    }
    std::optional<WorkerStatus> workerStatus() const override;
    bool importing() const override { return false; }  // a worker's import ends with it
    void stop() override;

    Supervisor& supervisor() { return supervisor_; }

private:
    Answer answerByOneOfSeveral(const Call& call);
    Answer drawnByOneOfSeveral(const Call& call);
    Answer metricsOfAll(const Call& call);
    void tellOthers(const Call& call);

    const WorkerBackendOptions options_;
    Supervisor supervisor_;
    std::optional<RendererQueue> queue_;  // only before several renderers
    OverloadCache overload_;
    JobJournal jobs_;
    std::atomic<bool> stopping_{false};
};

}  // namespace clerestory
