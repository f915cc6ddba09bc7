// The one door to the OpenGL thread: a thread that owns the Renderer, and a bounded queue before
// it.
//
// Does not: know HTTP requests or scenes; retry; reorder.
#pragma once

#include "renderer.h"
#include "server/clock.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <thread>

namespace clerestory {

class RenderQueue {
public:
    // Starts the thread and makes the Renderer in it; call identity() to wait for that.
    RenderQueue(const RendererOptions& options, std::size_t capacity);
    // Finishes what was accepted.
    ~RenderQueue();
    RenderQueue(const RenderQueue&) = delete;
    RenderQueue& operator=(const RenderQueue&) = delete;

    // Waits until the Renderer stands. Throws what its constructor threw.
    const RendererIdentity& identity() const;

    // Runs `work` on the OpenGL thread and waits for it. Work whose deadline passes while it waits
    // is dropped. Throws RequestError: full or stopping (503), over the deadline (504); and what
    // `work` throws. When the deadline passes in mid-work the work ends unheard, so it must own
    // what it touches.
    template <class Work>
    auto run(std::chrono::duration<double> patience, Work work) {
        using Result = std::invoke_result_t<Work, Renderer&>;
        auto task = std::make_shared<std::packaged_task<Result(Renderer&)>>(std::move(work));
        std::future<Result> result = task->get_future();
        const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(patience);
        push({.deadline = deadline, .work = [task](Renderer& r) { (*task)(r); }});
        if (result.wait_until(deadline) != std::future_status::ready) refuseLate(patience);
        try {
            return result.get();
        } catch (const std::future_error&) {  // dropped in the queue at the deadline
            refuseLate(patience);
        }
    }

    // The server's own work (scenes, warming): not counted in the capacity, not waited for.
    void post(std::function<void(Renderer&)> work);

    // From now on run() refuses; returns when what it accepted is done.
    void refuseNew();

    std::size_t depth() const;  // waiting or running, of run()
    std::size_t capacity() const { return capacity_; }
    bool hasRoom() const { return depth() < capacity_; }

private:
    struct Job {
        Clock::time_point deadline = Clock::time_point::max();
        std::function<void(Renderer&)> work;
        bool counted = true;
    };
    void push(Job job);
    [[noreturn]] static void refuseLate(std::chrono::duration<double> patience);
    int retryAfterSeconds() const;
    void serve(const RendererOptions& options);

    const std::size_t capacity_;
    mutable std::mutex mutex_;
    std::condition_variable wake_, idle_;
    std::deque<Job> jobs_;
    std::size_t counted_ = 0;
    double meanSeconds_ = 0.05;  // of a job, a running mean; only for Retry-After
    bool refusing_ = false;
    bool ending_ = false;
    std::promise<RendererIdentity> made_;
    std::shared_future<RendererIdentity> identity_;
    std::thread thread_;
};

}  // namespace clerestory
