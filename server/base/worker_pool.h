// A pool of threads that handle requests. Threads are started on demand and kept.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace clerestory {

class WorkerPool {
public:
    explicit WorkerPool(std::size_t maxThreads) : maxThreads_(maxThreads) {
        threads_.reserve(maxThreads);
    }
    ~WorkerPool() { finish(); }
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    // `work` must not throw. Throws if there is no thread and none can be started, or if memory is
    // exhausted; then `work` is not run.
    void run(std::function<void()> work);

    // Ends the threads after all queued work is done; run() must not be called any more.
    void finish();

private:
    void serve();

    const std::size_t maxThreads_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::function<void()>> waiting_;
    std::size_t idle_ = 0;
    bool ending_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace clerestory
