// Work that takes longer than a request may: a bounded queue of jobs and the one thread that runs
// them, alternating between clients; and functions that several jobs use: tracing a reference, and
// drawing frames alternately with clients. Finished jobs are kept for a while, under ids that
// cannot be guessed.
#pragma once

#include "server/base/holdings.h"
#include "server/queue/render_queue.h"
#include "server/scenes/scene_library.h"

#include "comparison/comparison.h"
#include "comparison/curve.h"

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace clerestory {

enum class JobState { queued, running, done, failed, cancelled };
std::string_view nameOf(JobState state);

struct JobPicture {
    std::string type;  // media type
    std::string bytes;
};

struct JobResult {
    std::variant<std::monostate, Comparison, Curve> value;  // without error pictures
    std::vector<JobPicture> pictures;                       // clients name them by index
};

struct JobStatus {
    std::string id;
    JobState state = JobState::queued;
    double progress = 0.0;                    // in [0, 1], never decreases
    std::string failure;                      // for users, when failed
    std::shared_ptr<const JobResult> result;  // when done
};

// How the work of a job reports its progress and learns that it is cancelled.
class JobControl {
public:
    // Progress in [0, 1]. Returns false if the job is cancelled: the work should return soon, with
    // any result.
    bool proceed(double progress) const { return report_(progress); }

private:
    friend class Jobs;
    explicit JobControl(std::function<bool(double)> report) : report_(std::move(report)) {}
    std::function<bool(double)> report_;
};

class Jobs {
public:
    using Work = std::function<JobResult(const JobControl&)>;

    // `capacity`: the most jobs that wait or run at once, at least 1.
    // A client has a share of them (server/base/holdings.h).
    explicit Jobs(std::size_t capacity);
    ~Jobs();  // cancels all jobs and waits for the one that runs
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    // `work` receives the id of the new job. `knownId`: the id of a job that continues, which has a
    // place without a check; if there is a job with this id, it is returned and nothing starts.
    // Throws RequestError 503 if the client
    // has its share of the queue. If the work throws, the job fails; the failure is the message of
    // a RequestError or InvalidRequest, and a general message for any other exception.
    JobStatus start(std::function<Work(const std::string& id)> work, const std::string& client,
                    const std::string& knownId = "");

    // Empty if there is no such job, or its result was discarded.
    std::optional<JobStatus> lookUp(const std::string& id) const;
    // As lookUp(), but throws RequestError 404.
    JobStatus find(const std::string& id) const;

    // Finished jobs stay finished. Throws like find().
    JobStatus cancel(const std::string& id);

    Holdings::Usage usage() const { return open_.usage(Pool::jobs); }

private:
    struct Job {
        JobStatus status;
        Work work;
        std::optional<Holdings::Held> place;  // until it has ended
        std::uint64_t round = 0;              // lower ones run first
        bool cancelled = false;

        void end(JobState state);
    };
    void serve();
    void run(Job& job);
    std::shared_ptr<Job> nextQueued() const;
    void discardOldResults(const Job& newest, const std::lock_guard<std::mutex>& lock);
    Job* find(std::string_view id, const std::lock_guard<std::mutex>&) const;
    Job& jobFor(const std::string& id, const std::lock_guard<std::mutex>& lock) const;

    Holdings open_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::shared_ptr<Job>> jobs_;  // oldest first
    std::uint64_t round_ = 0;                // of the job that started last
    bool ending_ = false;
    std::thread thread_;
};

// What jobs use; the references must outlive them.
struct JobResources {
    RenderQueue& queue;
    SceneLibrary& library;
    // Everything that can change a byte of the request's frame, as text.
    std::function<std::string(const FrameRequest&)> contentText;
};

// Thrown by drawInQueue() when the job is cancelled.
struct JobCancelled {};

// A copy of a request's scene with vertices and texels; of a list, of all in one. Takes as long as
// loading. Throws InvalidRequest if they are too large together.
Scene wholeScene(SceneLibrary& library, const FrameRequest& frame);

// The path-traced reference of a frame of this scene, which is wholeScene() of it. Null if
// `progress` returned false.
// Throws InvalidRequest if the frame names an environment map that is not loaded.
std::shared_ptr<const ReferenceRender> traceReference(EnvironmentLibrary& environments,
                                                      const Scene& scene, const FrameRequest& frame,
                                                      ReferenceMode mode, std::uint32_t samples,
                                                      std::uint64_t seed,
                                                      const std::function<bool(double)>& progress);

// On the thread that owns the renderer.
DrawnFrame drawTimed(Renderer& renderer, const FrameRequest& request,
                     const std::function<bool()>& abandoned = {});

// Waits for its turn in the queue, where clients' frames can come between two frames of a job. A
// frame that takes long is abandoned when clients wait, and repeated after them.
// Throws JobCancelled, and RequestError if the frame was abandoned several times.
DrawnFrame drawInQueue(const JobResources& resources, const FrameRequest& request,
                       const JobControl& control);

}  // namespace clerestory
