// The thread that owns the Renderer, the bounded, fair queue of the work for it, and a check that
// the renderer still draws correctly.
#pragma once

#include "server/base/call.h"
#include "server/base/problem.h"
#include "server/base/process.h"
#include "server/queue/fair_queue.h"

#include "renderer.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

namespace clerestory {

// The conditions of a piece of work in the queue.
struct Turn {
    std::string client;      // empty: the server itself
    std::uint64_t kind = 0;  // work of one kind takes about the same time
    std::chrono::duration<double> patience{10.0};
    std::shared_ptr<CancellationToken> cancellation;  // null: cannot be cancelled
    // Whether a frame that is being drawn ends when it is cancelled. A client that closed only its
    // own side can still read its frame: such frames end if other work waits.
    enum class EndsInProgress { never, ifOthersWait, always };
    EndsInProgress endsInProgress = EndsInProgress::ifOthersWait;
    // Added to the patience: how long it also waits while shaders are compiled, its own or others.
    std::chrono::duration<double> compilePatience{60.0};
};

// Of the renderer, since the start.
struct CompileTotals {
    std::uint64_t programs = 0, pipelines = 0;
    double seconds = 0.0;
};

// The least time of a sample that was seen in frames that made no objects, for a lower bound of the
// time of a frame that was never drawn. It does not rise, since a refusal could not be corrected by
// drawing the frame.
class SamplePrice {
public:
    void update(std::uint64_t samples, double seconds);
    double leastSeconds(std::uint64_t samples) const;  // 0: unknown

private:
    double secondsPerSample_ = 0.0;
};

class RenderQueue {
public:
    // Starts the thread, which creates the Renderer; identity() waits for it.
    RenderQueue(const RendererOptions& options, const FairQueue::Limits& limits);
    ~RenderQueue();  // finishes the accepted work
    RenderQueue(const RenderQueue&) = delete;
    RenderQueue& operator=(const RenderQueue&) = delete;

    // Waits until the Renderer is created. Throws what its constructor threw.
    const RendererIdentity& identity() const;

    // Runs `work` on the OpenGL thread and waits for it. Work whose deadline passes while it waits
    // is dropped, and so is that of a client that leaves. Deadlines are in the queue's time, which
    // stands still while shaders are compiled: that is not overload, and happens once. Throws
    // RequestError: full, stopping, left, or compiling for too long (503), over the deadline (504);
    // and what `work` throws. If the deadline passes while the work runs, its result is discarded
    // after this has returned, so the work must own everything that it uses.
    template <class Work>
    auto run(const Turn& turn, Work work) {
        using Result = std::invoke_result_t<Work, Renderer&>;
        auto task = std::make_shared<std::packaged_task<Result(Renderer&)>>(std::move(work));
        std::future<Result> result = task->get_future();
        const Place place(*this, turn, [task = std::move(task)](Renderer& r) { (*task)(r); });
        while (result.wait_for(place.left()) != std::future_status::ready) {
        }
        try {
            return result.get();
        } catch (const std::future_error&) {  // dropped
            throw RequestError(place.whyDropped());
        }
    }

    // Work of the server itself, queued as that of a client.
    template <class Work>
    auto run(std::chrono::duration<double> patience, Work work) {
        return run(Turn{.patience = patience}, std::move(work));
    }

    // Adds work that runs before all queued work, in order; does not wait for it. For scenes.
    void post(std::function<void(Renderer&)> work);

    // The problem with which run() would certainly refuse this client now. Does not block.
    std::optional<Problem> refusalFor(const std::string& client) const;

    // From now on run() refuses; returns when the accepted work is finished.
    void refuseNew();

    // A standby at rest releases its programs, too, if the driver is software. It loads them from
    // the driver's cache when it draws.
    void setStandby(bool standby);

    // Runs `step` repeatedly until it returns false: alternately with the work of clients, and
    // without pause while none waits.
    void inBackground(std::function<bool(Renderer&)> step);

    // How long the present piece of work has been running; 0 if none runs. Starts again with each
    // compiled program.
    std::chrono::duration<double> workingFor() const;

    // Whether the deadline of the work that runs has passed, so that no client waits for its
    // result.
    bool isOverdue() const;
    // Of the work of run() that is running; null if none runs or it cannot be cancelled.
    std::shared_ptr<CancellationToken> runningToken() const;

    CompileTotals compileTotals() const;
    // Whether shaders were compiled at or after that time.
    bool compiledSince(Clock::time_point then) const;

    std::size_t depth() const;  // waiting or running, of run()
    bool hasWaiting() const;    // of run()
    bool hasRoom() const;
    QueueUsage usage() const;  // of what waits in run()

private:
    using Work = std::function<void(Renderer&)>;
    struct Job {
        Work work;
        std::shared_ptr<Problem> dropped;                       // the reason if it is dropped
        std::shared_ptr<CancellationToken> cancellation = {};   // null: cannot be cancelled
        Clock::time_point deadline = Clock::time_point::max();  // in the queue's time
    };
    // What the thread works on.
    struct Running {
        std::shared_ptr<CancellationToken> cancellation;
        Clock::time_point deadline;
        std::uint64_t samples = 0;  // that its frame shades
    };
    // A place in the queue during run(); removes the work if run() ends before it starts.
    class Place {
    public:
        Place(RenderQueue& queue, const Turn& turn, Work work);
        ~Place();
        Place(const Place&) = delete;
        Place& operator=(const Place&) = delete;
        const Problem& whyDropped() const { return *dropped_; }
        // How long to wait before the next check. Throws RequestError if the time is over.
        Clock::duration left() const;

    private:
        RenderQueue& owner_;
        std::shared_ptr<CancellationToken> cancellation_;
        std::shared_ptr<Problem> dropped_ = std::make_shared<Problem>(internalError());
        std::chrono::duration<double> patience_;
        Clock::time_point longest_;   // the latest time, including compilation
        Clock::time_point deadline_;  // without the time of compilation
        FairQueue::Id id_ = 0;
    };

    Clock::time_point queueTime() const;
    void compiling(bool begins);
    FairQueue::Id push(const Turn& turn, Clock::time_point deadline, Job job);
    void withdraw(FairQueue::Id id, const Problem& why);
    Job dropped(FairQueue::Id id, const Problem& why);
    void serve(const RendererOptions& options);
    void requireTime(const FramePlan& plan);
    void servePosted(Renderer& renderer, std::unique_lock<std::mutex>& lock);
    void releaseIdleMemory(Renderer& renderer, std::unique_lock<std::mutex>& lock);
    void serveOne(Renderer& renderer, std::unique_lock<std::mutex>& lock);
    void serveBackground(Renderer& renderer, std::unique_lock<std::mutex>& lock);

    mutable std::mutex mutex_;
    std::condition_variable wake_, idle_;
    FairQueue queue_;
    std::unordered_map<FairQueue::Id, Job> jobs_;  // that wait in queue_
    std::deque<Work> posted_;
    std::deque<std::function<bool(Renderer&)>> background_;
    bool backgroundIsNext_ = true;
    Clock::duration compiled_{};  // time that compiling took in all
    std::optional<Clock::time_point> compilingSince_;
    Clock::time_point lastCompiled_{};
    CompileTotals compileTotals_;
    std::optional<Running> running_;  // of run()
    SamplePrice samplePrice_;
    std::optional<Clock::time_point> workingSince_;
    // Of releaseIdleMemory(), used by the thread only: the renderer's counters at the last call,
    // since when it is idle, and whether it has released what frames keep.
    std::uint64_t objectsMade_ = 0, trianglesDrawn_ = 0;
    Clock::time_point idleSince_{};
    bool resting_ = false;
    bool standby_ = false, programsReleased_ = false;
    bool refusing_ = false;
    bool ending_ = false;
    std::promise<RendererIdentity> made_;
    std::shared_future<RendererIdentity> identity_;
    std::thread thread_;
};

// Checks that the renderer still draws correctly: a tiny frame with a known result.
class Canary {
public:
    // Adds its scene to the renderer. `queue` must outlive this.
    explicit Canary(RenderQueue& queue);

    // Draws the frame, unless a frame was drawn, or a shader compiled, in the last seconds. Throws
    // RequestError 503 if the frame fails or is wrong. Thread-safe.
    void check();
    // A client's frame was drawn: check() needs no frame for some seconds.
    void frameWasDrawn();

private:
    RenderQueue& queue_;
    std::atomic<std::int64_t> lastDrawn_{0};  // milliseconds of Clock; 0: never
};

}  // namespace clerestory
